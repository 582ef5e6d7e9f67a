#include "prehend/shape/fallbacks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/LU>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::shape {
namespace {

using std::numbers::pi;
constexpr int kLeastSlices = 4;
constexpr double kSlices = 40;  // of the longest side

/// Corners of the convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Eigen::Vector2d> convex_outline(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  const auto turn = [](const Eigen::Vector2d& o, const Eigen::Vector2d& a,
                       const Eigen::Vector2d& b) {
    return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
  };
  for (const int pass : {0, 1}) {
    const std::size_t begin = hull.size() + 1;
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() > begin && turn(hull[hull.size() - 2], hull.back(), p) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    if (pass == 0) std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// Fills in what the view says about the fall-back's points.
void judge(Fallback& fallback, const FallbackInput& input) {
  for (const Eigen::Vector3d& p_T : fallback.points_T) {
    const PointEvidence e =
        evidence_about(input.map, input.camera, input.X_CT * p_T, input.depth_tolerance);
    fallback.contradicted += e.contradicted;
    fallback.coincident += e.coincident;
    fallback.unseen += e.unseen;
  }
  const double count = std::max<double>(1, static_cast<double>(fallback.points_T.size()));
  fallback.contradicted /= count;
  fallback.coincident /= count;
  fallback.unseen /= count;
}

struct Slice {
  double height = 0;                     // of its middle [m]
  std::vector<Eigen::Vector2d> outline;  // from the axis' first guess
  double radius = 0;
};

std::vector<Slice> slices_of(const FallbackInput& input, const Eigen::Vector2d& origin) {
  const auto& points = input.voting.points_T;
  double side = 0, low = points.front().z();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  low = box.min().z();
  side = std::max(box.sizes().maxCoeff() / kSlices, 1e-12);
  std::map<int, std::vector<Eigen::Vector2d>> cells;
  for (const Eigen::Vector3d& p : points) {
    cells[static_cast<int>((p.z() - low) / side)].push_back(p.head<2>() - origin);
  }
  std::vector<Slice> slices;
  for (auto& [cell, inside] : cells) {
    std::vector<Eigen::Vector2d> outline = convex_outline(std::move(inside));
    if (outline.size() >= 4) slices.push_back({low + (cell + 0.5) * side, std::move(outline), 0});
  }
  return slices;
}

/// The common axis of the slices' circles from the slices' origin, if the points tell one.
std::optional<Eigen::Vector2d> common_axis(const std::vector<Slice>& slices, double extent) {
  Eigen::Vector2d axis = Eigen::Vector2d::Zero();
  double spread = extent;  // m, of residuals; beyond it a point counts for little
  for (int iteration = 0; iteration < 8; ++iteration) {
    Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    std::vector<double> residuals;
    for (const Slice& slice : slices) {
      std::vector<double> radii;
      for (const auto& p : slice.outline) radii.push_back((p - axis).norm());
      std::nth_element(radii.begin(), radii.begin() + radii.size() / 2, radii.end());
      const double median = radii[radii.size() / 2];
      double weights = 0, mean_square = 0;
      Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      std::vector<double> weight;
      for (const auto& p : slice.outline) {
        const double residual = iteration == 0 ? 0 : ((p - axis).norm() - median) / spread;
        weight.push_back(1 / (1 + residual * residual));
        weights += weight.back();
        mean += weight.back() * p;
        mean_square += weight.back() * p.squaredNorm();
        residuals.push_back(std::abs((p - axis).norm() - median));
      }
      mean /= weights;
      mean_square /= weights;
      for (std::size_t i = 0; i < slice.outline.size(); ++i) {
        const Eigen::Vector2d r = slice.outline[i] - mean;
        matrix += weight[i] * r * r.transpose();
        right += weight[i] * 0.5 * (slice.outline[i].squaredNorm() - mean_square) * r;
      }
    }
    const double trace = matrix.trace();
    if (!(trace > 0) || matrix.determinant() < 1e-3 * trace * trace) return std::nullopt;
    axis = matrix.inverse() * right;
    if (!(axis.norm() < 2 * extent)) return std::nullopt;
    std::nth_element(residuals.begin(), residuals.begin() + residuals.size() / 2, residuals.end());
    spread = std::max(2 * residuals[residuals.size() / 2], 1e-3 * extent);
  }
  return axis;
}

}  // namespace

std::optional<Fallback> revolved(const FallbackInput& input) {
  const VotingPoints& voting = input.voting;
  const Eigen::Vector2d origin = voting.center_T.head<2>();
  std::vector<Slice> slices = slices_of(input, origin);
  if (slices.size() < kLeastSlices) return std::nullopt;
  const auto axis = common_axis(slices, voting.extent);
  if (!axis) return std::nullopt;

  Fallback fallback;
  fallback.method = CompletionMethod::kRotation;
  fallback.center_T = origin + *axis;
  double squares = 0, count = 0;
  for (Slice& slice : slices) {
    std::vector<double> radii;
    for (const auto& p : slice.outline) radii.push_back((p - *axis).norm());
    std::nth_element(radii.begin(), radii.begin() + radii.size() / 2, radii.end());
    slice.radius = radii[radii.size() / 2];
    for (const double radius : radii) squares += (radius - slice.radius) * (radius - slice.radius);
    count += static_cast<double>(radii.size());
  }
  fallback.misfit = std::sqrt(squares / count) / voting.extent;
  // The lowest slice is carried on to the table: nothing is seen below it.
  std::vector<std::pair<double, double>> rings;  // height, radius
  for (double z = 0.5 * input.spacing; z < slices.front().height; z += input.spacing) {
    rings.emplace_back(z, slices.front().radius);
  }
  for (std::size_t i = 0; i + 1 < slices.size(); ++i) {
    const double step = std::hypot(slices[i + 1].height - slices[i].height,
                                   slices[i + 1].radius - slices[i].radius);
    const int pieces = std::max(1, static_cast<int>(std::ceil(step / input.spacing)));
    for (int k = 0; k < pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      rings.emplace_back((1 - t) * slices[i].height + t * slices[i + 1].height,
                         (1 - t) * slices[i].radius + t * slices[i + 1].radius);
    }
  }
  rings.emplace_back(slices.back().height, slices.back().radius);
  for (const auto& [height, radius] : rings) {
    const int around = std::max(6, static_cast<int>(std::ceil(2 * pi * radius / input.spacing)));
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * pi * k / around;
      const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d p = fallback.center_T + radius * out;
      fallback.points_T.emplace_back(p.x(), p.y(), height);
      fallback.normals_T.emplace_back(out.x(), out.y(), 0);
    }
  }
  judge(fallback, input);
  return fallback;
}

namespace {

/// The seen footprint as cells of the table.
struct Footprint {
  Eigen::Vector2d low;         // corner of the first cell [m]
  double side = 0;             // of a cell [m]
  geometry::Image<float> top;  // greatest height over each cell [m]; 0 where nothing was seen

  Eigen::Vector2d middle(int u, int v) const {
    return low + side * Eigen::Vector2d(u + 0.5, v + 0.5);
  }
};

/// The cells that the image's border reaches through others without a point within `reach` cells
/// (up, down and to the sides), and what is as near to those: what is open beyond gaps of 2
/// `reach`.
geometry::MaskImage outside_of(const geometry::Image<float>& top, int reach) {
  const int width = top.width, height = top.height;
  const auto any_near = [&](int u, int v, const auto& is) {
    for (int y = std::max(0, v - reach); y <= std::min(height - 1, v + reach); ++y) {
      for (int x = std::max(0, u - reach); x <= std::min(width - 1, u + reach); ++x) {
        if (is(x, y)) return true;
      }
    }
    return false;
  };
  geometry::MaskImage far_out(width, height, 0), outside(width, height, 0);
  std::vector<std::pair<int, int>> reached{{0, 0}};
  far_out.at(0, 0) = 255;
  while (!reached.empty()) {
    const auto [u, v] = reached.back();
    reached.pop_back();
    for (const auto& [x, y] : {std::pair{u - 1, v}, {u + 1, v}, {u, v - 1}, {u, v + 1}}) {
      if (!top.contains(x, y) || far_out.at(x, y) > 0) continue;
      if (any_near(x, y, [&](int a, int b) { return top.at(a, b) > 0; })) continue;
      far_out.at(x, y) = 255;
      reached.emplace_back(x, y);
    }
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      outside.at(u, v) =
          any_near(u, v, [&](int a, int b) { return far_out.at(a, b) > 0; }) ? 255 : 0;
    }
  }
  return outside;
}

/// With a border of empty cells round it; cells that only seen ones surround, but for gaps as those
/// between points of a side that is seen at a slant, take their height.
Footprint footprint_of(const FallbackInput& input) {
  constexpr int kReach = 1;  // cells
  constexpr int kBorder = kReach + 1;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& p : input.voting.points_T) box.extend(Eigen::Vector2d(p.head<2>()));
  Footprint footprint;
  footprint.side = 0.035 * input.voting.extent;
  footprint.low = box.min() - Eigen::Vector2d::Constant(kBorder * footprint.side);
  const Eigen::Vector2d cells = (box.sizes() / footprint.side).array().floor() + (2 * kBorder + 1);
  const int width = static_cast<int>(cells.x()), height = static_cast<int>(cells.y());
  footprint.top = geometry::Image<float>(width, height, 0.f);
  for (const Eigen::Vector3d& p : input.voting.points_T) {
    const Eigen::Vector2d cell = (p.head<2>() - footprint.low) / footprint.side;
    // Rounding may put a point of the box's border into the empty one.
    float& top =
        footprint.top.at(std::clamp(static_cast<int>(cell.x()), kBorder, width - 1 - kBorder),
                         std::clamp(static_cast<int>(cell.y()), kBorder, height - 1 - kBorder));
    top = std::max(top, static_cast<float>(p.z()));
  }
  const geometry::MaskImage outside = outside_of(footprint.top, kReach);
  float last = 0;
  for (std::size_t i = 0; i < footprint.top.data.size(); ++i) {
    float& top = footprint.top.data[i];
    if (top == 0 && outside.data[i] == 0) top = last;
    last = top;
  }
  return footprint;
}

/// Spread of the footprint across over along: 0 for a line.
double slenderness(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& center) {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector2d r = (p - center).head<2>();
    covariance += r * r.transpose();
  }
  const double half_trace = 0.5 * covariance.trace();
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - covariance.determinant()));
  return std::sqrt(std::max(0.0, half_trace - root) / (half_trace + root));
}

}  // namespace

std::optional<Fallback> extruded(const FallbackInput& input) {
  constexpr double kLeastSlenderness = 0.15;
  if (slenderness(input.voting.points_T, input.voting.center_T) < kLeastSlenderness) {
    return std::nullopt;
  }
  const Footprint footprint = footprint_of(input);
  Fallback fallback;
  fallback.method = CompletionMethod::kExtrusion;
  double cells = 0;
  const int along = std::max(1, static_cast<int>(std::ceil(footprint.side / input.spacing)));
  for (int v = 0; v < footprint.top.height; ++v) {
    for (int u = 0; u < footprint.top.width; ++u) {
      const double top = footprint.top.at(u, v);
      if (top <= 0) continue;
      fallback.center_T += footprint.middle(u, v);
      cells += 1;
      // A wall on each side where the neighbour is empty, a little within the cell's edge: the
      // outermost points lie somewhere in the cell.
      for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        if (footprint.top.at(u + du, v + dv) > 0) continue;
        const Eigen::Vector2d out(du, dv), side(-dv, du);
        for (int k = 0; k < along; ++k) {
          const Eigen::Vector2d p =
              footprint.middle(u, v) +
              footprint.side * (0.15 * out + ((k + 0.5) / along - 0.5) * side);
          for (double z = 0.5 * input.spacing; z < top; z += input.spacing) {
            fallback.points_T.emplace_back(p.x(), p.y(), z);
            fallback.normals_T.emplace_back(out.x(), out.y(), 0);
          }
        }
      }
    }
  }
  if (fallback.points_T.empty()) return std::nullopt;
  fallback.center_T /= cells;
  judge(fallback, input);
  return fallback;
}

std::optional<Fallback> hulled(const FallbackInput& input) {
  std::vector<Eigen::Vector3d> corners = input.voting.points_T;
  for (const Eigen::Vector3d& p : input.voting.points_T) corners.emplace_back(p.x(), p.y(), 0);
  const geometry::TriangleMesh hull = geometry::convex_hull(corners);
  Fallback fallback;
  fallback.method = CompletionMethod::kConvexHull;
  double area = 0;
  for (const Eigen::Vector3i& t : hull.triangles) {
    const Eigen::Vector3d a = hull.vertices[t.x()];
    const Eigen::Vector3d ab = hull.vertices[t.y()] - a, ac = hull.vertices[t.z()] - a;
    const Eigen::Vector3d across = ab.cross(ac);
    const double twice = across.norm();
    // Its foot is left out, as those of the others: which way it faces, no view tells.
    if (std::max({a.z(), a.z() + ab.z(), a.z() + ac.z()}) < 0.5 * input.spacing) continue;
    // Evenly by area: a quasi-random sequence (Roberts' R2), folded into the triangle.
    const double count = std::ceil(0.5 * twice / (input.spacing * input.spacing));
    for (double k = 1; k <= count; ++k) {
      double x = std::fmod(0.5 + 0.7548776662466927 * k, 1.0);
      double y = std::fmod(0.5 + 0.5698402909980532 * k, 1.0);
      if (x + y > 1) {
        x = 1 - x;
        y = 1 - y;
      }
      fallback.points_T.push_back(a + x * ab + y * ac);
      fallback.normals_T.push_back(across / twice);
    }
    fallback.center_T += twice * (a + (ab + ac) / 3).head<2>();
    area += twice;
  }
  if (area > 0) fallback.center_T /= area;
  judge(fallback, input);
  return fallback;
}

}  // namespace prehend::shape
