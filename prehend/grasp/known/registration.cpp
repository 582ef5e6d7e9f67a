#include "prehend/grasp/known/registration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include <Eigen/Dense>

#include "prehend/geometry/symmetric_solve.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using Random = std::mt19937_64;
constexpr int kCorrespondences = 60;    // most similar points of the model, of which one is drawn
constexpr double kDistanceSlack = 1.5;  // spacings, by which two pairs' distances may differ
constexpr double kAngleSlack = 0.2;     // of the cosines of two pairs' angles
constexpr std::size_t kScored = 100;    // seen points that a pose is judged by at first
constexpr double kLeastGlance = 0.5;    // share of a fifth of those
constexpr double kAlikeTurn = 0.2;      // rad
constexpr double kAlikeShift = 3;       // spacings

// std::uniform_int_distribution draws differently in every standard library.
std::size_t draw(Random& random, std::size_t count) { return random() % count; }

// Two oriented points of a surface.
struct PointPair {
  Eigen::Vector3d p, n, q, m;  // points p, q [m], their normals n, m
  Eigen::Vector3d way() const { return q - p; }
};

PointPair pair_of(const DescribedPoints& points, std::size_t i, std::size_t k) {
  return {points.points[i], points.normals[i], points.points[k], points.normals[k]};
}

// Point pair features (Drost et al., CVPR 2010, equation 1), the angles as cosines.
bool are_alike(const PointPair& a, const PointPair& b, double spacing) {
  const double d = a.way().norm(), e = b.way().norm();
  if (std::abs(d - e) > kDistanceSlack * spacing || e <= 0) return false;
  return std::abs(a.n.dot(a.m) - b.n.dot(b.m)) < kAngleSlack &&
         std::abs(a.n.dot(a.way()) / d - b.n.dot(b.way()) / e) < kAngleSlack &&
         std::abs(a.m.dot(a.way()) / d - b.m.dot(b.way()) / e) < kAngleSlack;
}

// Axes along the way between the points and across it towards their mean normal: from more than one
// normal, as each is uncertain. Nothing when the normals lie along the way.
std::optional<Eigen::Matrix3d> axes_of(const PointPair& pair) {
  const Eigen::Vector3d x = pair.way().normalized();
  Eigen::Vector3d across = pair.n + pair.m;
  across -= across.dot(x) * x;
  if (across.norm() < 0.3) {
    across = pair.n - pair.n.dot(x) * x;
    if (across.norm() < 0.3) return std::nullopt;
  }
  Eigen::Matrix3d axes;
  axes.col(0) = x;
  axes.col(2) = across.normalized();
  axes.col(1) = axes.col(2).cross(x);
  return axes;
}

// The motion that takes one pair to the other, the middles upon one another.
std::optional<RigidTransform> motion_of(const PointPair& from_S, const PointPair& to_O) {
  const auto from = axes_of(from_S), to = axes_of(to_O);
  if (!from || !to) return std::nullopt;
  RigidTransform X_OS = RigidTransform::Identity();
  X_OS.linear() = *to * from->transpose();
  X_OS.translation() = 0.5 * (to_O.p + to_O.q) - X_OS.linear() * (0.5 * (from_S.p + from_S.q));
  return X_OS;
}

struct Pose {
  RigidTransform X_OS;
  double share = 0;
};

bool are_alike(const RigidTransform& a, const RigidTransform& b, const Eigen::Vector3d& centre_S,
               double spacing) {
  const Eigen::AngleAxisd turn(a.linear().transpose() * b.linear());
  return std::abs(turn.angle()) < kAlikeTurn &&
         (a * centre_S - b * centre_S).norm() < kAlikeShift * spacing;
}

}  // namespace

std::vector<RigidTransform> consensus_poses(const DescribedPoints& seen_S,
                                            const RegisteredModel& model,
                                            const ConsensusOptions& options) {
  const DescribedPoints& samples_O = model.samples_O;
  const std::size_t count = seen_S.points.size();
  std::vector<std::vector<int>> alike(count);
  for (std::size_t i = 0; i < count; ++i) {
    alike[i] = model.index.nearest(seen_S.features[i], kCorrespondences);
  }
  std::vector<Eigen::Vector3d> scored;
  const std::size_t stride = std::max<std::size_t>(1, count / kScored);
  for (std::size_t i = 0; i < count; i += stride) scored.push_back(seen_S.points[i]);
  std::vector<Eigen::Vector3d> glance;
  for (std::size_t i = 0; i < scored.size(); i += 5) glance.push_back(scored[i]);
  Eigen::Vector3d centre_S = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : seen_S.points) centre_S += p / static_cast<double>(count);

  Random random(options.seed);
  std::vector<Pose> poses;
  for (int sample = 0; sample < options.samples; ++sample) {
    const std::size_t i = draw(random, count), k = draw(random, count);
    const PointPair from_S = pair_of(seen_S, i, k);
    const std::size_t to_i = static_cast<std::size_t>(alike[i][draw(random, alike[i].size())]);
    const std::size_t to_k = static_cast<std::size_t>(alike[k][draw(random, alike[k].size())]);
    if (from_S.way().norm() < options.least_distance) continue;
    const PointPair to_O = pair_of(samples_O, to_i, to_k);
    if (!are_alike(from_S, to_O, options.spacing)) continue;
    const auto X_OS = motion_of(from_S, to_O);
    if (!X_OS) continue;
    // Coarsely: the pose is off by about the spacing of the points it comes from. Most are soon
    // seen to be wrong.
    if (explained_by(glance, model.surface_O, *X_OS, 2 * options.tolerance).share < kLeastGlance) {
      continue;
    }
    const double share = explained_by(scored, model.surface_O, *X_OS, 2 * options.tolerance).share;
    poses.push_back({*X_OS, share});
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Pose& a, const Pose& b) { return a.share > b.share; });
  std::vector<RigidTransform> kept;
  for (const Pose& pose : poses) {
    if (kept.size() == static_cast<std::size_t>(options.kept)) break;
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const RigidTransform& other) {
      return are_alike(pose.X_OS, other, centre_S, options.spacing);
    });
    if (is_new) kept.push_back(pose.X_OS);
  }
  return kept;
}

RigidTransform refined_pose(const OrientedPoints& seen_S, const geometry::MeshQuery& surface_O,
                            const RigidTransform& X_OS, double tolerance) {
  constexpr int kSteps = 30;
  constexpr double kLeastCosine = 0.5;  // between seen and true normal
  constexpr double kStill = 1e-5;       // m and rad, of a step that ends it
  const auto& mesh = surface_O.mesh();
  RigidTransform X = X_OS;
  for (int step = 0; step < kSteps; ++step) {
    const double bound = std::max(2.0, 7.5 - 0.5 * step) * tolerance;
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < seen_S.points.size(); ++i) {
      const Eigen::Vector3d p = X * seen_S.points[i];
      const auto nearest = surface_O.nearest(p, bound);
      if (!nearest) continue;
      const auto& corners = mesh.triangles[static_cast<std::size_t>(nearest->triangle)];
      const auto corner = [&](int k) {
        return mesh.vertices[static_cast<std::size_t>(corners[k])];
      };
      const Eigen::Vector3d normal =
          (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
      // False for a triangle without area, too.
      if (!(normal.dot(X.linear() * seen_S.normals[i]) > kLeastCosine)) continue;
      Eigen::Matrix<double, 6, 1> row;
      row << p.cross(normal), normal;
      A += row * row.transpose();
      b -= row * normal.dot(p - nearest->point);
    }
    // What the points do not tell, as the turn of a bottle, stays as it is.
    A.diagonal().array() += 1e-9 + 1e-6 * A.diagonal().mean();
    const Eigen::Matrix<double, 6, 1> x = geometry::symmetric_solve<6>(A, b);
    if (!x.allFinite()) return X;
    RigidTransform step_O = RigidTransform::Identity();
    const Eigen::Vector3d turn = x.head<3>();
    if (turn.norm() > 0) {
      step_O.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    step_O.translation() = x.tail<3>();
    X = step_O * X;
    if (x.norm() < kStill) break;
  }
  return X;
}

Explained explained_by(const std::vector<Eigen::Vector3d>& points_S,
                       const geometry::MeshQuery& surface_O, const RigidTransform& X_OS,
                       double tolerance) {
  Explained result;
  if (points_S.empty()) return result;
  std::size_t count = 0;
  double squares = 0;
  for (const Eigen::Vector3d& p_S : points_S) {
    const auto nearest = surface_O.nearest(X_OS * p_S, tolerance);
    if (!nearest) continue;
    ++count;
    squares += nearest->distance * nearest->distance;
  }
  result.share = static_cast<double>(count) / static_cast<double>(points_S.size());
  if (count > 0) result.residual = std::sqrt(squares / static_cast<double>(count));
  return result;
}

}  // namespace prehend::grasp
