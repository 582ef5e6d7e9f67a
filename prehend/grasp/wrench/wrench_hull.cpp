#include "prehend/grasp/wrench/wrench_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}
#include <Eigen/LU>
#include <Eigen/SVD>

#include "prehend/grasp/wrench/wrench_polytope.h"

namespace prehend::grasp {
namespace {

constexpr int kDimension = 6;
constexpr int kMostSteps = 1000;
constexpr int kMostFacets = 20000;
/// Qhull's whole hull of unit wrenches.
class FullHull {
 public:
  explicit FullHull(const Wrenches& wrenches) : points_(wrenches) {
    qh_zero(&qhull_, nullptr);
    char options[] = "qhull Qt";
    const int failed = qh_new_qhull(&qhull_, kDimension, static_cast<int>(points_.cols()),
                                    points_.data(), False, options, nullptr, nullptr);
    if (failed != 0) {
      release();
      throw std::runtime_error("Qhull cannot make the hull of the wrenches: error " +
                               std::to_string(failed));
    }
  }
  ~FullHull() { release(); }
  FullHull(const FullHull&) = delete;
  FullHull& operator=(const FullHull&) = delete;

  double volume() {
    qh_getarea(&qhull_, qhull_.facet_list);
    return qhull_.totvol;
  }
  /// The facet nearest to the origin: its distance, and its outward normal.
  double nearest(Vector6& normal) const {
    double least = std::numeric_limits<double>::infinity();
    for (const facetT* facet = qhull_.facet_list; facet && facet->next; facet = facet->next) {
      if (-facet->offset >= least) continue;
      least = -facet->offset;
      normal = Eigen::Map<const Vector6>(facet->normal);
    }
    return least;
  }

 private:
  void release() {
    qh_freeqhull(&qhull_, !qh_ALL);
    int count = 0, bytes = 0;
    qh_memfreeshort(&qhull_, &count, &bytes);
  }

  Wrenches points_;
  qhT qhull_;
};

double largest_norm(const Wrenches& wrenches) {
  return wrenches.cols() == 0 ? 0 : std::sqrt(wrenches.colwise().squaredNorm().maxCoeff());
}

void check(const Wrenches& wrenches, double tolerance) {
  if (!wrenches.allFinite()) throw std::invalid_argument("wrench_hull: a wrench is not finite");
  if (!(tolerance > 0 && tolerance < 1)) {
    throw std::invalid_argument("wrench_hull: tolerance must be in (0, 1)");
  }
}

/// The point of the hull nearest to the origin, as a combination of at most seven columns.
struct Nearest {
  Vector6 point;
  std::vector<int> corral;
};

/// Weights of sum 1 with the least norm of `count` columns' combination.
Eigen::VectorXd affine_minimum(const Wrenches& wrenches, const std::vector<int>& corral) {
  const auto count = static_cast<Eigen::Index>(corral.size());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 7, 7> gram(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      gram(i, j) = gram(j, i) = 1 + wrenches.col(corral[static_cast<std::size_t>(i)])
                                        .dot(wrenches.col(corral[static_cast<std::size_t>(j)]));
    }
  }
  const Eigen::VectorXd weights = gram.partialPivLu().solve(Eigen::VectorXd::Ones(count));
  return weights / weights.sum();
}

Nearest nearest_point(const Wrenches& wrenches, double tolerance) {
  Eigen::Index least = 0;
  wrenches.colwise().squaredNorm().minCoeff(&least);
  Nearest nearest{wrenches.col(least), {static_cast<int>(least)}};
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(1);
  for (int step = 0; step < kMostSteps; ++step) {
    const double squared = nearest.point.squaredNorm();
    if (squared <= tolerance * tolerance) break;
    Eigen::Index next = 0;
    const double reach = (nearest.point.transpose() * wrenches).minCoeff(&next);
    if (squared - reach <= 1e-12 || nearest.corral.size() == kDimension + 1 ||
        std::find(nearest.corral.begin(), nearest.corral.end(), next) != nearest.corral.end()) {
      break;
    }
    nearest.corral.push_back(static_cast<int>(next));
    weights.conservativeResize(weights.size() + 1);
    weights[weights.size() - 1] = 0;
    while (true) {
      const Eigen::VectorXd target = affine_minimum(wrenches, nearest.corral);
      if (!target.allFinite()) return nearest;
      if (target.minCoeff() > 1e-14) {
        weights = target;
        break;
      }
      // Towards the target as far as all weights stay positive; the first that vanishes goes.
      double along = 1;
      for (Eigen::Index i = 0; i < weights.size(); ++i) {
        if (target[i] <= 1e-14) along = std::min(along, weights[i] / (weights[i] - target[i]));
      }
      weights += along * (target - weights);
      Eigen::Index gone = 0;
      double smallest = std::numeric_limits<double>::infinity();
      for (Eigen::Index i = 0; i < weights.size(); ++i) {
        if (target[i] <= 1e-14 && weights[i] < smallest) {
          smallest = weights[i];
          gone = i;
        }
      }
      nearest.corral.erase(nearest.corral.begin() + gone);
      const Eigen::Index rest = weights.size() - gone - 1;
      weights.segment(gone, rest) = weights.tail(rest).eval();
      weights.conservativeResize(weights.size() - 1);
      weights /= weights.sum();
    }
    nearest.point.setZero();
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      nearest.point += weights[i] * wrenches.col(nearest.corral[static_cast<std::size_t>(i)]);
    }
  }
  return nearest;
}

/// Adds columns until the corral spans as many dimensions as it can; their number.
int extend(const Wrenches& wrenches, std::vector<int>& corral, double tolerance) {
  std::vector<Vector6> basis;
  const Vector6 origin = wrenches.col(corral.front());
  Wrenches rest = wrenches.colwise() - origin;
  const auto take = [&](const Vector6& direction) {
    basis.push_back(direction);
    rest -= direction * (direction.transpose() * rest);
  };
  for (std::size_t i = 1; i < corral.size(); ++i) {
    const Vector6 left = rest.col(corral[i]);
    if (left.norm() > tolerance) take(left.normalized());
  }
  while (basis.size() < kDimension) {
    Eigen::Index farthest = 0;
    const double reach = std::sqrt(rest.colwise().squaredNorm().maxCoeff(&farthest));
    if (reach <= tolerance) break;
    corral.push_back(static_cast<int>(farthest));
    take(rest.col(farthest) / reach);
  }
  return static_cast<int>(basis.size());
}

/// Of wrenches of at most unit norm.
WrenchHull unit_hull(const Wrenches& wrenches, const WrenchHullOptions& options) {
  WrenchHull result;
  Nearest nearest = nearest_point(wrenches, options.tolerance);
  result.distance = nearest.point.norm();
  result.rank = extend(wrenches, nearest.corral, options.tolerance);
  if (result.distance > options.tolerance) {
    result.weakest = -nearest.point / result.distance;
    return result;
  }
  result.distance = 0;
  if (result.rank < kDimension) {
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(wrenches, Eigen::ComputeFullU);
    result.weakest = svd.matrixU().col(kDimension - 1);
    return result;
  }
  // The corral may hold points that others made dependent; a simplex has seven.
  if (nearest.corral.size() != kDimension + 1) {
    return reference_wrench_hull(wrenches, options.tolerance);
  }
  WrenchPolytope polytope(wrenches, nearest.corral);
  // The hull reaches at least as far as epsilon in every direction: the least reach seen bounds it.
  double bound = std::numeric_limits<double>::infinity();
  while (true) {
    const int facet = polytope.nearest(bound);
    if (facet < 0 || polytope.failed() || polytope.made() > kMostFacets) {
      return reference_wrench_hull(wrenches, options.tolerance);
    }
    const double offset = polytope.offset(facet);
    Eigen::Index farthest = 0;
    const double reach = (polytope.normal(facet).transpose() * wrenches).maxCoeff(&farthest);
    bound = std::min(bound, reach + 1e-9);
    const bool final = reach <= offset + 1e-12 || reach <= offset * (1 + options.precision);
    if (final || (options.closure_only && offset > options.tolerance)) {
      polytope.refine(facet);
      result.facets = polytope.made();
      result.closed = polytope.offset(facet) > options.tolerance;
      result.epsilon = result.closed ? polytope.offset(facet) : 0;
      result.weakest = -polytope.normal(facet);
      return result;
    }
    polytope.grow(static_cast<int>(farthest), facet, 1e-12);
  }
}

}  // namespace

bool may_be_closed(const Wrenches& wrenches) {
  if (wrenches.cols() <= kDimension) return false;
  const Vector6 mean = wrenches.rowwise().mean();
  if ((mean.transpose() * wrenches).minCoeff() > 0) return false;
  return (wrenches.rowwise().maxCoeff().array() > 0).all() &&
         (wrenches.rowwise().minCoeff().array() < 0).all();
}

double epsilon_bound(const Wrenches& wrenches) {
  if (wrenches.cols() == 0) return 0;
  const Vector6 most = wrenches.rowwise().maxCoeff(), least = wrenches.rowwise().minCoeff();
  return std::max(0.0, std::min(most.minCoeff(), (-least).minCoeff()));
}

WrenchHull wrench_hull(const Wrenches& wrenches, const WrenchHullOptions& options) {
  check(wrenches, options.tolerance);
  if (!(options.precision >= 0 && options.precision < 1)) {
    throw std::invalid_argument("wrench_hull: precision must be in [0, 1)");
  }
  const double scale = largest_norm(wrenches);
  if (!(scale > 0)) return {};
  WrenchHull result = unit_hull(wrenches / scale, options);
  result.epsilon *= scale;
  result.distance *= scale;
  return result;
}

double wrench_volume(const Wrenches& wrenches) {
  check(wrenches, 0.5);
  const double scale = largest_norm(wrenches);
  if (!(scale > 0) || wrench_hull(wrenches).rank < kDimension) return 0;
  return FullHull(wrenches / scale).volume() * std::pow(scale, kDimension);
}

WrenchHull reference_wrench_hull(const Wrenches& wrenches, double tolerance) {
  check(wrenches, tolerance);
  WrenchHull result;
  const double scale = largest_norm(wrenches);
  if (!(scale > 0)) return result;
  const Wrenches unit = wrenches / scale;
  Wrenches spread = unit.colwise() - unit.col(0).eval();
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(spread, Eigen::ComputeFullU);
  svd.setThreshold(tolerance);
  result.rank = static_cast<int>(svd.rank());
  if (result.rank < kDimension) {
    result.weakest = svd.matrixU().col(kDimension - 1);
    return result;
  }
  Vector6 normal;
  const double least = FullHull(unit).nearest(normal);
  result.weakest = -normal;
  result.closed = least > tolerance;
  result.epsilon = result.closed ? least * scale : 0;
  return result;
}

}  // namespace prehend::grasp
