#include "prehend/grasp/wrench/wrench_polytope.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>

namespace prehend::grasp {
namespace {

constexpr double kThin = 1e-10;  // smallest edge of a facet across the others
constexpr double kLargestError = 1e-12;
constexpr double kRounding = 4e-16;

}  // namespace

WrenchPolytope::WrenchPolytope(const Wrenches& wrenches, const std::vector<int>& simplex)
    : wrenches_(wrenches),
      inside_(Vector6::Zero()),
      farthest_(std::numeric_limits<double>::infinity()) {
  facets_.reserve(1024);
  for (const int i : simplex) inside_ += wrenches.col(i) / (kDimension + 1);
  facets_.resize(kDimension + 1);
  // Facet k lacks vertex k, and is the neighbour across the ridge that another one has without k.
  for (int out = 0; out <= kDimension; ++out) {
    Facet& facet = at(out);
    for (int i = 0, n = 0; i <= kDimension; ++i) {
      if (i == out) continue;
      facet.vertices[static_cast<std::size_t>(n)] = simplex[static_cast<std::size_t>(i)];
      facet.neighbors[static_cast<std::size_t>(n++)] = i;
    }
    set_plane_by_points(facet);
    keep(out);
  }
}

int WrenchPolytope::index_of(const std::array<int, kDimension>& list, int value) {
  int i = 0;
  while (i < kDimension - 1 && list[static_cast<std::size_t>(i)] != value) ++i;
  return i;
}

void WrenchPolytope::set_plane_by_points(Facet& facet) {
  Eigen::Matrix<double, kDimension, kDimension - 1> edges;
  const Vector6 origin = wrenches_.col(facet.vertices[0]);
  for (int i = 1; i < kDimension; ++i) {
    edges.col(i - 1) = wrenches_.col(facet.vertices[static_cast<std::size_t>(i)]) - origin;
  }
  const Eigen::HouseholderQR<decltype(edges)> qr(edges);
  const double thinnest = qr.matrixQR().diagonal().cwiseAbs().minCoeff();
  failed_ = failed_ || !(thinnest > kThin);
  facet.normal = Vector6::Unit(kDimension - 1);
  facet.normal.applyOnTheLeft(qr.householderQ());
  facet.offset = facet.normal.dot(origin);
  facet.error = kRounding / std::max(thinnest, kThin);
  if (facet.normal.dot(inside_) > facet.offset) {
    facet.normal = -facet.normal;
    facet.offset = -facet.offset;
  }
}

int WrenchPolytope::new_place() {
  if (free_.empty()) {
    facets_.emplace_back();
    return static_cast<int>(facets_.size()) - 1;
  }
  const int place = free_.back();
  free_.pop_back();
  return place;
}

void WrenchPolytope::keep(int facet) {
  Facet& kept = at(facet);
  kept.serial = made_++;
  if (!(kept.offset < farthest_)) return;
  heap_.push_back({kept.offset, facet, kept.serial});
  std::push_heap(heap_.begin(), heap_.end(),
                 [](const Entry& a, const Entry& b) { return a.offset > b.offset; });
}

int WrenchPolytope::nearest(double farthest) {
  farthest_ = std::min(farthest_, farthest);
  while (!heap_.empty()) {
    const Entry& first = heap_.front();
    if (at(first.facet).serial == first.serial) {
      return first.offset < farthest_ ? first.facet : -1;
    }
    std::pop_heap(heap_.begin(), heap_.end(),
                  [](const Entry& a, const Entry& b) { return a.offset > b.offset; });
    heap_.pop_back();
  }
  return -1;
}

bool WrenchPolytope::sees(int facet, const Vector6& p, double tolerance) {
  Facet& seen = at(facet);
  if (seen.round != round_) {
    seen.round = round_;
    seen.height = seen.normal.dot(p) - seen.offset;
    seen.visible = seen.height > tolerance;
    if (seen.visible) {
      seen.made.fill(-1);
      visible_.push_back(facet);
    }
  }
  return seen.visible;
}

/// Finds the neighbours of a new facet over the ridges that hold the point: round each of its
/// faces without the point and one vertex more there is, beside it, one other new facet.
void WrenchPolytope::connect(int facet, int old_facet, int replaced) {
  for (int w = 0; w < kDimension; ++w) {
    if (w == replaced) continue;
    int current = old_facet, out = w;
    int kept = at(old_facet).vertices[static_cast<std::size_t>(replaced)];
    while (true) {
      const int next = at(current).neighbors[static_cast<std::size_t>(out)];
      if (!(at(next).round == round_ && at(next).visible)) break;
      const int entered = index_of(at(next).neighbors, current);
      out = index_of(at(next).vertices, kept);
      kept = at(next).vertices[static_cast<std::size_t>(entered)];
      current = next;
    }
    at(facet).neighbors[static_cast<std::size_t>(w)] =
        at(current).made[static_cast<std::size_t>(out)];
  }
}

void WrenchPolytope::grow(int point, int facet, double tolerance) {
  const Vector6 p = wrenches_.col(point);
  ++round_;
  visible_.clear();
  if (!sees(facet, p, tolerance)) {
    failed_ = true;
    return;
  }
  for (std::size_t v = 0; v < visible_.size(); ++v) {
    for (int i = 0; i < kDimension; ++i) {
      sees(at(visible_[v]).neighbors[static_cast<std::size_t>(i)], p, tolerance);
    }
  }
  const std::size_t count = visible_.size();
  for (std::size_t v = 0; v < count; ++v) {
    const int old_facet = visible_[v];
    for (int i = 0; i < kDimension; ++i) {
      const int beyond = at(old_facet).neighbors[static_cast<std::size_t>(i)];
      if (at(beyond).visible && at(beyond).round == round_) continue;
      const int place = new_place();
      Facet& made = at(place);
      Facet& old = at(old_facet);
      Facet& other = at(beyond);
      made.vertices = old.vertices;
      made.vertices[static_cast<std::size_t>(i)] = point;
      made.neighbors[static_cast<std::size_t>(i)] = beyond;
      made.round = 0;
      made.visible = false;
      other.neighbors[static_cast<std::size_t>(index_of(other.neighbors, old_facet))] = place;
      old.made[static_cast<std::size_t>(i)] = place;
      // The plane through the ridge of both and the point.
      const double a = std::max(0.0, -other.height), b = old.height;
      made.normal = a * old.normal + b * other.normal;
      const double length = made.normal.norm();
      made.error = (a * old.error + b * other.error + kRounding * (a + b)) / length;
      if (made.error < kLargestError) {
        made.normal /= length;
        made.offset = (a * old.offset + b * other.offset) / length;
      } else {
        set_plane_by_points(made);
      }
      keep(place);
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    for (int i = 0; i < kDimension; ++i) {
      const int made = at(visible_[v]).made[static_cast<std::size_t>(i)];
      if (made >= 0) connect(made, visible_[v], i);
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    at(visible_[v]).serial = -1;
    free_.push_back(visible_[v]);
  }
}

}  // namespace prehend::grasp
