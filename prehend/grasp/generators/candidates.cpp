#include "prehend/grasp/generators/candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/generators/directions.h"
#include "prehend/grasp/generators/held_line.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Without the points inside the octagon of those that are farthest in eight directions, which are
// most (S. G. Akl and G. T. Toussaint, "A fast convex hull algorithm", Information Processing
// Letters 7(5), 1978).
std::vector<Eigen::Vector2d> without_inner(const std::vector<Eigen::Vector2d>& points) {
  constexpr double kDirections[8][2] = {{1, 0},  {1, 1},   {0, 1},  {-1, 1},
                                        {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};  // anticlockwise
  if (points.size() < 32) return points;
  double farthest[8];
  Eigen::Vector2d corners[8];
  std::fill(farthest, farthest + 8, -std::numeric_limits<double>::infinity());
  for (const Eigen::Vector2d& p : points) {
    for (int k = 0; k < 8; ++k) {
      const double along = kDirections[k][0] * p.x() + kDirections[k][1] * p.y();
      if (along <= farthest[k]) continue;
      farthest[k] = along;
      corners[k] = p;
    }
  }
  std::vector<Eigen::Vector2d> outer;
  for (const Eigen::Vector2d& p : points) {
    bool inside = true;
    for (int k = 0; k < 8 && inside; ++k) {
      const Eigen::Vector2d side = corners[(k + 1) % 8] - corners[k];
      inside = side.isZero(0) || cross(side, p - corners[k]) > 1e-9 * side.squaredNorm();
    }
    if (!inside) outer.push_back(p);
  }
  return outer;
}

// Andrew's monotone chain; counter-clockwise without collinear points.
std::vector<Eigen::Vector2d> planar_hull(const std::vector<Eigen::Vector2d>& all) {
  std::vector<Eigen::Vector2d> points = without_inner(all);
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  const auto extend = [&hull](const Eigen::Vector2d& p, std::size_t base) {
    while (hull.size() >= base + 2 &&
           cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
      hull.pop_back();
    }
    hull.push_back(p);
  };
  for (const auto& p : points) extend(p, 0);
  const std::size_t base = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) extend(*p, base);
  hull.pop_back();
  return hull;
}

// Unit directions from the centroid to the hand. See sample_candidates.
std::vector<Eigen::Vector3d> circle_directions(const Eigen::Matrix3d& axes,
                                               const Eigen::Vector3d& start, int count) {
  const Eigen::Vector3d major = axes.col(0);
  Eigen::Vector3d along = perpendicular_part(major, start);
  if (along.isZero()) along = perpendicular_part(axes.col(1), start);
  Eigen::Vector3d across = perpendicular_part(start, major);
  if (across.isZero()) across = axes.col(1);
  const Eigen::Vector3d third = major.cross(across);

  std::vector<Eigen::Vector3d> directions;
  const auto add = [&directions](const Eigen::Vector3d& d) {
    const bool known = std::any_of(directions.begin(), directions.end(),
                                   [&d](const auto& other) { return (d - other).norm() < 1e-6; });
    if (!known) directions.push_back(d);
  };
  for (int circle = 0; circle < 2; ++circle) {
    const Eigen::Vector3d& u = circle == 0 ? start : across;
    const Eigen::Vector3d& v = circle == 0 ? along : third;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      add((std::cos(angle) * u + std::sin(angle) * v).normalized());
    }
  }
  return directions;
}

// Points of the mesh whose outline is the mesh's from every side: the corners of its hull.
std::vector<Eigen::Vector3d> outer_points(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> points;
  std::vector<bool> taken(mesh.vertices.size(), false);
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (!taken[triangle[k]]) points.push_back(mesh.vertices[triangle[k]]);
      taken[triangle[k]] = true;
    }
  }
  try {
    return geometry::convex_hull(points).vertices;
  } catch (const geometry::InputError&) {
    return points;  // flat: it has no hull
  }
}

ApproachView view_along(const std::vector<Eigen::Vector3d>& outer, const Eigen::Vector3d& centroid,
                        const Eigen::Vector3d& approach) {
  ApproachView view;
  const Eigen::Matrix3d frame = frame_about(approach);
  std::vector<Eigen::Vector2d> outline;
  outline.reserve(outer.size());
  view.near_side = std::numeric_limits<double>::infinity();
  view.far_side = -view.near_side;
  for (const auto& vertex : outer) {
    const Eigen::Vector3d p = frame.transpose() * (vertex - centroid);
    outline.emplace_back(p.x(), p.y());
    view.near_side = std::min(view.near_side, p.z());
    view.far_side = std::max(view.far_side, p.z());
  }
  const auto [width, across] = smallest_width(outline);
  view.width = width;
  view.R_WA.col(2) = approach;
  view.R_WA.col(1) = (frame.col(0) * across.x() + frame.col(1) * across.y()).normalized();
  view.R_WA.col(0) = view.R_WA.col(1).cross(approach);
  return view;
}

}  // namespace

void CandidateOptions::validate() const {
  const text::Require require{"CandidateOptions."};
  require(directions_per_circle > 0, "directions_per_circle must be positive");
  require(rolls > 0, "rolls must be positive");
  require(standoffs > 0, "standoffs must be positive");
  require(least_engagement > 0, "least_engagement must be positive");
  require(table_clearance >= 0, "table_clearance must not be negative");
  require(!lateral_offsets.empty(), "lateral_offsets must not be empty");
  for (double offset : lateral_offsets) {
    require(std::isfinite(offset), "lateral_offsets must be finite");
  }
}

SmallestWidth smallest_width(const std::vector<Eigen::Vector2d>& points) {
  const std::vector<Eigen::Vector2d> hull = planar_hull(points);
  SmallestWidth best;
  if (hull.size() < 2) return best;
  best.width = std::numeric_limits<double>::infinity();
  // The point farthest from a side moves on round the hull with it (rotating calipers).
  std::size_t opposite = 1;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    const Eigen::Vector2d across = Eigen::Vector2d(-edge.y(), edge.x()).normalized();
    const auto height = [&](std::size_t j) { return across.dot(hull[j] - hull[i]); };
    for (std::size_t k = 0; k < hull.size(); ++k) {
      const std::size_t next = (opposite + 1) % hull.size();
      if (!(height(next) > height(opposite))) break;
      opposite = next;
    }
    const double width = std::max(0.0, height(opposite));
    if (width < best.width - 1e-9) best = {width, across};
  }
  return best;
}

Eigen::Matrix3d principal_axes(const TriangleMesh& mesh) {
  // Exact second moments of the triangles' area: A/12 (sum of v v' + 9 c c') about the mean.
  double area = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d origin = mesh.triangles.empty() ? Eigen::Vector3d::Zero().eval()
                                                        : mesh.vertices[mesh.triangles.front()[0]];
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin,
                          c = mesh.vertices[t[2]] - origin;
    const double triangle_area = (b - a).cross(c - a).norm() / 2;
    const Eigen::Vector3d mean = (a + b + c) / 3;
    area += triangle_area;
    first += triangle_area * mean;
    second +=
        triangle_area / 12 *
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + 9 * mean * mean.transpose());
  }
  if (area <= 0) return Eigen::Matrix3d::Identity();
  const Eigen::Vector3d mean = first / area;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(second / area -
                                                              mean * mean.transpose());
  Eigen::Matrix3d axes;
  axes.col(0) = solver.eigenvectors().col(2);
  axes.col(1) = solver.eigenvectors().col(1);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

std::vector<ApproachView> approach_views(const TriangleMesh& mesh_W,
                                         const Eigen::Vector3d& centroid_W,
                                         const geometry::Plane& table,
                                         const Reachability& reachability,
                                         const CandidateOptions& options) {
  options.validate();
  const Eigen::Vector3d start =
      reachability.approach_W ? Eigen::Vector3d(-*reachability.approach_W) : table.normal;
  const std::vector<Eigen::Vector3d> outer = outer_points(mesh_W);
  std::vector<ApproachView> views;
  for (const auto& direction :
       circle_directions(principal_axes(mesh_W), start, options.directions_per_circle)) {
    views.push_back(view_along(outer, centroid_W, -direction));
  }
  return views;
}

std::vector<Candidate> sample_candidates(const TriangleMesh& mesh_W,
                                         const Eigen::Vector3d& centroid_W,
                                         const geometry::Plane& table, double tip_z,
                                         const Reachability& reachability,
                                         const CandidateOptions& options) {
  return sample_candidates(approach_views(mesh_W, centroid_W, table, reachability, options),
                           centroid_W, table, tip_z, options);
}

std::vector<Candidate> sample_candidates(const std::vector<ApproachView>& views,
                                         const Eigen::Vector3d& centroid_W,
                                         const geometry::Plane& table, double tip_z,
                                         const CandidateOptions& options) {
  options.validate();
  std::vector<Candidate> candidates;
  for (const ApproachView& view : views) {
    const Eigen::Vector3d direction = -view.R_WA.col(2);
    const std::vector<double> depths =
        tip_depths(centroid_W, -direction, view.near_side + options.least_engagement, view.far_side,
                   options.standoffs, table, options.table_clearance);
    for (int roll = 0; roll < options.rolls; ++roll) {
      const double angle = std::numbers::pi * roll / options.rolls;
      const Eigen::Matrix3d R_WG =
          view.R_WA * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      for (double depth : depths) {
        for (double offset : options.lateral_offsets) {
          Candidate candidate;
          candidate.approach_W = -direction;
          candidate.standoff = -depth;
          candidate.roll = angle;
          candidate.lateral_offset = offset;
          candidate.outline_width = view.width;
          candidate.X_WG.linear() = R_WG;
          candidate.X_WG.translation() =
              centroid_W + offset * R_WG.col(0) + (tip_z - depth) * direction;
          candidates.push_back(candidate);
        }
      }
    }
  }
  return candidates;
}

}  // namespace prehend::grasp
