#include "prehend/calibration/work_area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "prehend/calibration/degenerate_data.h"

namespace prehend::calibration {
namespace {

constexpr double kLeastSide = 0.25;    // m, of a work area
constexpr double kStrip = 0.01;        // m, across an edge
constexpr double kEdgeBand = 0.05;     // m, of the rectangle's side in which its points are
constexpr double kCornerShare = 0.08;  // of a side at both ends, where the other sides are
constexpr int kImageBorder = 3;        // pixels
constexpr double kHuber = 0.002;       // m

// A point of a table.
struct OnTable {
  Eigen::Vector3d p_A;
  bool at_border;  // of its image
};

geometry::Plane plane_through(const std::vector<OnTable>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const OnTable& point : points) mean += point.p_A / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const OnTable& point : points) {
    scatter += (point.p_A - mean) * (point.p_A - mean).transpose();
  }
  geometry::Plane plane;
  plane.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  plane.offset = plane.normal.dot(mean);
  return plane;
}

// Organized clouds end where the image does: whether a pixel without a neighbour outward is there.
bool is_at_border(const geometry::PointCloud& cloud, int index) {
  if (!cloud.organized()) return false;
  const int u = index % cloud.width, v = index / cloud.width;
  return u < kImageBorder || v < kImageBorder || u >= cloud.width - kImageBorder ||
         v >= cloud.height - kImageBorder;
}

// Coordinates on the plane.
struct Flat {
  Eigen::Vector2d p;
  bool at_border;
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Counterclockwise (A. Andrew, "Another efficient algorithm for convex hulls in two dimensions",
// Information Processing Letters 9(5), 1979).
std::vector<Eigen::Vector2d> hull_of(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Eigen::Vector2d> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t least = hull.size() + 1;
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() > least &&
             cross(hull.back() - hull[hull.size() - 2], p - hull[hull.size() - 2]) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// Direction of the smallest rectangle's first side; one side of it lies on the hull (H. Freeman, R.
// Shapira, CACM 18(7), 1975).
Eigen::Vector2d rectangle_direction(const std::vector<Eigen::Vector2d>& hull) {
  Eigen::Vector2d best(1, 0);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d side = hull[(i + 1) % hull.size()] - hull[i];
    if (!(side.norm() > 1e-9)) continue;
    const Eigen::Vector2d x = side.normalized(), y(-x.y(), x.x());
    Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
    for (const Eigen::Vector2d& p : hull) {
      const Eigen::Array2d q(p.dot(x), p.dot(y));
      low = low.min(q);
      high = high.max(q);
    }
    const double area = (high - low).prod();
    if (area < least) {
      least = area;
      best = x;
    }
  }
  return best;
}

// normal . p = offset, normal outward.
struct EdgeLine {
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
  double offset = 0, rms = 0;
  bool is_real = true;
};

EdgeLine edge_line(const std::vector<Flat>& points, const Eigen::Vector2d& outward, double reach,
                   double spacing) {
  const Eigen::Vector2d along(-outward.y(), outward.x());
  double low = 1e9, high = -1e9;
  for (const Flat& point : points) {
    low = std::min(low, point.p.dot(along));
    high = std::max(high, point.p.dot(along));
  }
  const double corner = kCornerShare * (high - low);
  std::map<int, const Flat*> outermost;  // of each strip
  for (const Flat& point : points) {
    const double at = point.p.dot(along);
    if (at < low + corner || at > high - corner) continue;
    const Flat*& strip = outermost[static_cast<int>(std::floor(at / kStrip))];
    if (!strip || strip->p.dot(outward) < point.p.dot(outward)) strip = &point;
  }
  // offset + slope * along, Huber's weights.
  double offset = reach, slope = 0;
  int at_border = 0, count = 0;
  for (int round = 0; round < 20; ++round) {
    Eigen::Matrix2d A = 1e-12 * Eigen::Matrix2d::Identity();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (const auto& [strip, point] : outermost) {
      const double out = point->p.dot(outward), at = point->p.dot(along);
      if (round == 0 && out < reach - kEdgeBand) continue;  // a corner is cut off there
      const double off = std::abs(out - offset - slope * at);
      const double weight = round == 0 ? 1 : std::min(1.0, kHuber / std::max(off, 1e-12));
      const Eigen::Vector2d row(1, at);
      A += weight * row * row.transpose();
      b += weight * row * out;
    }
    const Eigen::Vector2d x = A.ldlt().solve(b);
    offset = x(0);
    slope = x(1);
  }
  EdgeLine edge;
  double squares = 0;
  for (const auto& [strip, point] : outermost) {
    const double off = point->p.dot(outward) - offset - slope * point->p.dot(along);
    if (std::abs(off) > 0.5 * kEdgeBand) continue;
    squares += off * off;
    at_border += point->at_border;
    ++count;
  }
  edge.normal = (outward - slope * along).normalized();
  edge.offset = offset / std::sqrt(1 + slope * slope) + 0.5 * spacing;
  edge.rms = count > 0 ? std::sqrt(squares / count) : 0;
  edge.is_real = 2 * at_border < count;
  return edge;
}

Eigen::Vector2d meeting(const EdgeLine& a, const EdgeLine& b) {
  Eigen::Matrix2d normals;
  normals << a.normal.transpose(), b.normal.transpose();
  return normals.inverse() * Eigen::Vector2d(a.offset, b.offset);
}

// Highest of the level planes where up is known, else the one that is most like a table.
perception::Table table_of(const TableView& view, perception::TableOptions options) {
  try {
    if (!view.X_AC) return perception::find_table(view.cloud_C, options);
    const Eigen::Vector3d up_C = view.X_AC->linear().transpose().col(2);
    options.min_extent = std::max(options.min_extent, kLeastSide);
    std::vector<perception::Table> tables = perception::find_tables(view.cloud_C, options, up_C);
    const auto height = [&](const perception::Table& table) {
      Eigen::Vector3d middle_C = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& p_C : table.hull_C) {
        middle_C += p_C / static_cast<double>(table.hull_C.size());
      }
      return (*view.X_AC * middle_C).z();
    };
    return *std::max_element(tables.begin(), tables.end(),
                             [&](const auto& a, const auto& b) { return height(a) < height(b); });
  } catch (const geometry::InputError& error) {
    throw geometry::InputError((view.name.empty() ? "" : view.name + ": ") + error.problem(),
                               view.X_AC ? "Look at the table from above, and give the camera's "
                                           "poses in a frame whose z is up"
                                         : "Look at the table from above, so that it fills much of "
                                           "the image");
  }
}

}  // namespace

WorkAreaFit calibrate_work_area(const std::vector<TableView>& views,
                                const WorkAreaOptions& options) {
  if (views.empty()) {
    throw DegenerateData("no views", "there is no cloud", "Record one that shows the table");
  }
  for (const TableView& view : views) {
    if (view.X_AC || views.size() == 1) continue;
    throw DegenerateData("camera's poses missing",
                         fmt::format("{} of {} views has none", view.name, views.size()),
                         "Give one view, or where the camera was at each");
  }
  WorkAreaFit fit;
  std::vector<std::vector<OnTable>> points;
  std::vector<OnTable> all;
  for (const TableView& view : views) {
    const perception::Table table = table_of(view, options.table);
    const geometry::RigidTransform X_AC = view.X_AC.value_or(geometry::RigidTransform::Identity());
    points.emplace_back();
    for (const int i : table.inliers) {
      const Eigen::Vector3d p_C = view.cloud_C.points[static_cast<std::size_t>(i)].cast<double>();
      points.back().push_back({X_AC * p_C, is_at_border(view.cloud_C, i)});
    }
    all.insert(all.end(), points.back().begin(), points.back().end());
  }
  fit.plane_A = plane_through(all);
  const Eigen::Vector3d eye_A = views.front().X_AC
                                    ? Eigen::Vector3d(views.front().X_AC->translation())
                                    : Eigen::Vector3d::Zero();
  if (fit.plane_A.signed_distance(eye_A) < 0) {
    fit.plane_A = {-fit.plane_A.normal, -fit.plane_A.offset};
  }
  double squares = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    TableViewFit of;
    of.name = views[v].name;
    of.points = static_cast<int>(points[v].size());
    double view_squares = 0;
    for (const OnTable& point : points[v]) {
      const double height = fit.plane_A.signed_distance(point.p_A);
      of.mean += height / static_cast<double>(points[v].size());
      view_squares += height * height;
    }
    squares += view_squares;
    of.rms = std::sqrt(view_squares / static_cast<double>(points[v].size()));
    const Eigen::Vector3d normal = plane_through(points[v]).normal;
    of.tilt = std::atan2(normal.cross(fit.plane_A.normal).norm(),
                         std::abs(normal.dot(fit.plane_A.normal)));
    fit.views.push_back(of);
    if (of.tilt > options.most_tilt || std::abs(of.mean) > options.most_offset) {
      throw DegenerateData(
          "views disagree",
          fmt::format(
              "the table of {} is tilted by {:.2f} degrees and {:.1f} mm off the common one",
              of.name.empty() ? "a view" : of.name, of.tilt * 180 / M_PI, 1e3 * of.mean),
          "Calibrate where the camera is again (`prehend calibrate hand-eye`), or leave the view "
          "out");
    }
  }
  fit.rms = std::sqrt(squares / static_cast<double>(all.size()));

  const Eigen::Vector3d normal = fit.plane_A.normal;
  const Eigen::Vector3d x_A = normal.unitOrthogonal(), y_A = normal.cross(x_A);
  const Eigen::Vector3d origin = normal * fit.plane_A.offset;
  std::vector<Flat> flat;
  std::vector<Eigen::Vector2d> places;
  for (const OnTable& point : all) {
    places.emplace_back((point.p_A - origin).dot(x_A), (point.p_A - origin).dot(y_A));
    flat.push_back({places.back(), point.at_border});
  }
  const std::vector<Eigen::Vector2d> hull = hull_of(places);
  const Eigen::Vector2d x = rectangle_direction(hull);
  double area = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    area += 0.5 * cross(hull[i], hull[(i + 1) % hull.size()]);
  }
  // Of one view, as far as all of the table is equally dense.
  const double spacing =
      std::sqrt(area / (static_cast<double>(all.size()) / static_cast<double>(views.size())));
  std::array<EdgeLine, 4> lines;
  for (std::size_t side = 0; side < 4; ++side) {
    const Eigen::Vector2d outward =
        Eigen::Rotation2Dd(0.5 * M_PI * static_cast<double>(side)) * Eigen::Vector2d(x.y(), -x.x());
    double reach = -1e9;
    for (const Eigen::Vector2d& p : hull) reach = std::max(reach, p.dot(outward));
    lines[side] = edge_line(flat, outward, reach, spacing);
  }
  std::array<Eigen::Vector2d, 4> corners;
  for (std::size_t side = 0; side < 4; ++side) {
    corners[side] = meeting(lines[(side + 3) % 4], lines[side]);
  }
  for (std::size_t side = 0; side < 4; ++side) {
    WorkAreaEdge& edge = fit.edges[side];
    const auto in_A = [&](const Eigen::Vector2d& p) -> Eigen::Vector3d {
      return origin + p.x() * x_A + p.y() * y_A;
    };
    edge.from_A = in_A(corners[side]);
    edge.to_A = in_A(corners[(side + 1) % 4]);
    edge.rms = lines[side].rms;
    edge.is_real = lines[side].is_real;
    if (!edge.is_real) {
      fit.remarks.push_back(
          fmt::format("Edge {} is where the image ends; the table may go on.", side + 1));
    }
  }
  const auto length_of = [&](std::size_t side) {
    return (fit.edges[side].to_A - fit.edges[side].from_A).norm();
  };
  const double first = 0.5 * (length_of(0) + length_of(2));
  const double second = 0.5 * (length_of(1) + length_of(3));
  fit.length = std::max(first, second);
  fit.width = std::min(first, second);
  return fit;
}

}  // namespace prehend::calibration
