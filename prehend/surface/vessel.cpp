#include "prehend/surface/vessel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <utility>

#include <flann/flann.hpp>
#include <opencv2/imgproc.hpp>

namespace prehend::surface {
namespace {

constexpr double kCellSpacings = 3;
constexpr double kLeastDepth = 0.008;          // m, of water
constexpr double kLeastDepthShare = 0.1;       // of the height
constexpr double kLeastAreaShare = 0.1;        // of the footprint
constexpr double kThickest = 0.015;            // m: what is thicker is no wall
constexpr double kAssumedThickness = 0.004;    // m
constexpr std::size_t kMostWallPoints = 8000;  // points, whose distances are measured
constexpr double kLooksUp = 0.7;               // cosine
constexpr double kLeastPaired = 0.2;           // of the points that line the hollow's upper half

constexpr float kEmpty = -1;  // height of a cell without points

TableGrid grid_about(const geometry::PointCloud& cloud, const geometry::Plane& table, double cell) {
  TableGrid grid;
  grid.table = table;
  grid.x = table.normal.unitOrthogonal();
  grid.y = table.normal.cross(grid.x);
  grid.cell = cell;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3f& p : cloud.points) box.extend(grid.on_table(p));
  // With empty cells all round, that drain: as many as what closes gaps reaches over.
  constexpr double kRing = 3;
  grid.low = box.min() - Eigen::Vector2d::Constant(kRing * cell);
  const Eigen::Vector2d cells = ((box.max() - grid.low) / cell).array().floor() + 1 + kRing;
  grid.width = static_cast<int>(cells.x());
  grid.height = static_cast<int>(cells.y());
  return grid;
}

/// The highest points over the cells of the table [m]; kEmpty where there are none.
geometry::Image<float> top_of(const geometry::PointCloud& cloud, const TableGrid& grid) {
  geometry::Image<float> top(grid.width, grid.height, kEmpty);
  for (const Eigen::Vector3f& p : cloud.points) {
    const auto [u, v] = grid.cell_of(p);
    top.at(u, v) = std::max({top.at(u, v), static_cast<float>(grid.height_of(p)), 0.f});
  }
  // A cell of a rim whose points are missing is no spout.
  cv::Mat image(top.height, top.width, CV_32F, top.data.data()), closed;
  cv::morphologyEx(image, closed, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  closed.copyTo(image);
  return top;
}

/// Where water would stand over `top` when it rained: its level over each cell. It drains at the
/// border.
geometry::Image<float> flooded(const geometry::Image<float>& top) {
  geometry::Image<float> level(top.width, top.height, kEmpty);
  using Cell = std::pair<float, std::size_t>;  // level, index
  std::priority_queue<Cell, std::vector<Cell>, std::greater<>> front;
  front.emplace(0.f, 0);
  level.data[0] = 0;
  while (!front.empty()) {
    const auto [at, index] = front.top();
    front.pop();
    const int u = static_cast<int>(index % top.width), v = static_cast<int>(index / top.width);
    for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (!level.contains(u + du, v + dv) || level.at(u + du, v + dv) != kEmpty) continue;
      level.at(u + du, v + dv) = std::max(at, top.at(u + du, v + dv));
      front.emplace(level.at(u + du, v + dv),
                    static_cast<std::size_t>(v + dv) * top.width + u + du);
    }
  }
  return level;
}

/// Points on the other side of a wall.
class OppositePoints {
 public:
  explicit OppositePoints(const geometry::PointCloud& cloud)
      : cloud_(cloud),
        index_(
            flann::Matrix<float>(const_cast<float*>(cloud.points.front().data()), cloud.size(), 3),
            flann::KDTreeSingleIndexParams(15)) {
    index_.buildIndex();
  }

  /// Calls `visit` with each point within `distance` of point i whose normal is opposite, and with
  /// how far it is behind i along i's normal (negative: before it).
  template <class Visit>
  void visit(std::size_t i, double distance, double aside, Visit&& visit) {
    const Eigen::Vector3f& p = cloud_.points[i];
    const Eigen::Vector3f& n = cloud_.normals[i];
    flann::SearchParams search(flann::FLANN_CHECKS_UNLIMITED, 0, false);
    index_.radiusSearch(flann::Matrix<float>(const_cast<float*>(p.data()), 1, 3), indices_,
                        distances_, static_cast<float>(distance * distance), search);
    for (const int j : indices_.front()) {
      if (cloud_.normals[j].dot(n) > -0.5f) continue;
      const Eigen::Vector3f to = cloud_.points[j] - p;
      const double behind = -static_cast<double>(to.dot(n));
      if ((to + static_cast<float>(behind) * n).norm() > aside) continue;
      visit(static_cast<std::size_t>(j), behind);
    }
  }

 private:
  const geometry::PointCloud& cloud_;
  flann::KDTreeSingleIndex<flann::L2_Simple<float>> index_;
  std::vector<std::vector<int>> indices_;
  std::vector<std::vector<float>> distances_;
};

/// The median of the distances of which some are to what is no wall, too far off: of those within
/// twice the lower quartile.
double wall_distance(std::vector<double> distances) {
  std::sort(distances.begin(), distances.end());
  const double most = 2 * std::max(distances[distances.size() / 4], 0.0);
  const auto end = std::upper_bound(distances.begin(), distances.end(), most);
  return distances[static_cast<std::size_t>(end - distances.begin()) / 2];
}

/// The voxels that hold points.
class Occupied {
 public:
  Occupied(const geometry::PointCloud& cloud, const TableGrid& grid) : grid_(grid) {
    for (const Eigen::Vector3f& p : cloud.points) {
      const auto [u, v] = grid.cell_of(p);
      cells_.insert({u, v, level(grid.height_of(p))});
    }
  }
  /// Whether there are points at about this height [m] over the table, from one cell before `p` to
  /// `reach` [m] behind it.
  bool anything(const Eigen::Vector2d& p, const Eigen::Vector2d& direction, double reach,
                double height) const {
    const Eigen::Vector2d aside = grid_.cell * Eigen::Vector2d(-direction.y(), direction.x());
    for (double way = -grid_.cell; way <= reach; way += 0.5 * grid_.cell) {
      for (const double side : {-1.0, 0.0, 1.0}) {
        const auto [u, v] = grid_.cell_of(grid_.point(p + way * direction + side * aside, 0));
        if (cells_.contains({u, v, level(height)})) return true;
      }
    }
    return false;
  }

 private:
  int level(double height) const { return static_cast<int>(std::floor(height / grid_.cell)); }

  const TableGrid& grid_;
  std::set<std::array<int, 3>> cells_;
};

/// Upright walls from the rim to the floor where no wall was seen: rims that stand beside deep
/// water, over nothing.
geometry::PointCloud missing_walls(const geometry::PointCloud& cloud, const Basin& basin,
                                   double spacing, double thickness) {
  constexpr int kRimAbout = 2, kWaterAbout = 6;  // cells: a rim's course, and where its water is
  const TableGrid& grid = basin.grid;
  const Occupied occupied(cloud, grid);
  // A wall that leans inwards by up to 45 degrees is no missing one, but that across is another.
  const double widest = 0.3 * std::sqrt(basin.area);
  // The rim's points by cell.
  std::map<std::pair<int, int>, std::vector<Eigen::Vector2d>> rims;
  for (const Eigen::Vector3f& p : cloud.points) {
    if (std::abs(grid.height_of(p) - basin.rim) > 0.5 * grid.cell) continue;
    rims[grid.cell_of(p)].push_back(grid.on_table(p));
  }
  geometry::PointCloud walls;
  for (const auto& [cell, points] : rims) {
    const auto [u, v] = cell;
    Eigen::Vector2d wet = Eigen::Vector2d::Zero(), rim = wet;
    double wet_cells = 0, rim_points = 0;
    for (int dv = -kWaterAbout; dv <= kWaterAbout; ++dv) {
      for (int du = -kWaterAbout; du <= kWaterAbout; ++du) {
        if (basin.level.contains(u + du, v + dv) && basin.level.at(u + du, v + dv) > 0) {
          wet += grid.middle(u + du, v + dv);
          wet_cells += 1;
        }
        if (std::max(std::abs(du), std::abs(dv)) > kRimAbout) continue;
        const auto beside = rims.find({u + du, v + dv});
        if (beside == rims.end()) continue;
        for (const Eigen::Vector2d& p : beside->second) rim += p;
        rim_points += static_cast<double>(beside->second.size());
      }
    }
    if (wet_cells == 0) continue;
    rim /= rim_points;
    const Eigen::Vector2d inwards = (wet / wet_cells - rim).normalized();
    for (const Eigen::Vector2d& p : points) {
      const Eigen::Vector2d middle = p - (p - rim).dot(inwards) * inwards;
      std::vector<double> nothing_at;
      int heights = 0;
      for (double height = basin.rim - 0.5 * spacing; height > 0; height -= spacing, ++heights) {
        const double reach = std::min(basin.rim - height + grid.cell, widest);
        if (!occupied.anything(middle, inwards, reach, height)) nothing_at.push_back(height);
      }
      if (2 * static_cast<int>(nothing_at.size()) < heights) continue;
      for (const double height : nothing_at) {
        for (const double side : {0.5, -0.5}) {
          // The inner side ends at the floor, which is a thickness over the table.
          if (side > 0 && height < thickness) continue;
          walls.points.push_back(grid.point(middle + side * thickness * inwards, height));
          walls.normals.push_back(grid.across(2 * side * inwards));
        }
      }
    }
  }
  return walls;
}

/// A floor, one thickness over the table, under water that hides it.
geometry::PointCloud missing_floor(const Basin& basin, double spacing, double thickness) {
  const TableGrid& grid = basin.grid;
  geometry::PointCloud floor;
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      if (basin.level.at(u, v) <= 0 || basin.floor.at(u, v) > 0) continue;
      for (double dv = 0.5 * spacing; dv < grid.cell; dv += spacing) {
        for (double du = 0.5 * spacing; du < grid.cell; du += spacing) {
          const Eigen::Vector2d corner = grid.low + grid.cell * Eigen::Vector2d(u, v);
          floor.points.push_back(grid.point(corner + Eigen::Vector2d(du, dv), thickness));
          floor.normals.push_back(grid.table.normal.cast<float>());
        }
      }
    }
  }
  return floor;
}

/// Whether water stands behind an outer point of a wall, where the hollow would begin.
bool water_behind(const Basin& basin, const Eigen::Vector3f& p, const Eigen::Vector3f& n,
                  double thickness) {
  const TableGrid& grid = basin.grid;
  const double height = grid.height_of(p);
  if (std::abs(n.cast<double>().dot(grid.table.normal)) > kLooksUp) return false;
  const double way = thickness + 1.5 * grid.cell;
  const auto [u, v] = grid.cell_of(p - static_cast<float>(way) * n);
  if (!basin.level.contains(u, v)) return false;
  const auto level = static_cast<double>(basin.level.at(u, v));
  const auto floor = static_cast<double>(basin.floor.at(u, v));
  return height < level && height > std::max(floor, thickness);
}

}  // namespace

std::optional<Basin> find_basin(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                double spacing) {
  if (cloud.empty() || cloud.normals.size() != cloud.size()) return std::nullopt;
  Basin basin;
  basin.grid = grid_about(cloud, table, kCellSpacings * spacing);
  const TableGrid& grid = basin.grid;
  const geometry::Image<float> top = top_of(cloud, grid);
  const geometry::Image<float> level = flooded(top);
  double highest = 0, covered = 0;
  for (const float height : top.data) {
    highest = std::max(highest, static_cast<double>(height));
    covered += height != kEmpty;
  }
  const double least = std::max(kLeastDepth, kLeastDepthShare * highest);

  basin.level = geometry::Image<float>(grid.width, grid.height, 0.f);
  basin.floor = top;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double wet = 0;
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const auto depth = static_cast<double>(level.at(u, v) - std::max(top.at(u, v), 0.f));
      if (depth < 0.5 * least) continue;
      basin.level.at(u, v) = level.at(u, v);
      middle += grid.middle(u, v);
      wet += 1;
      if (depth <= basin.depth) continue;
      basin.depth = depth;
      basin.rim = static_cast<double>(level.at(u, v));
    }
  }
  if (basin.depth < least || wet < kLeastAreaShare * covered) return std::nullopt;
  middle /= wet;
  basin.area = wet * grid.cell * grid.cell;

  basin.lines.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto [u, v] = grid.cell_of(cloud.points[i]);
    float about = 0;  // level of the water in this cell or near it
    constexpr int kNear = 2;
    for (int dv = -kNear; dv <= kNear; ++dv) {
      for (int du = -kNear; du <= kNear; ++du) {
        if (basin.level.contains(u + du, v + dv)) {
          about = std::max(about, basin.level.at(u + du, v + dv));
        }
      }
    }
    if (grid.height_of(cloud.points[i]) > static_cast<double>(about)) continue;
    const Eigen::Vector3f n = cloud.normals[i];
    const Eigen::Vector3f inwards = grid.across(middle - grid.on_table(cloud.points[i]));
    basin.lines[i] = n.cast<double>().dot(table.normal) > kLooksUp || n.dot(inwards) > 0;
  }
  return basin;
}

VesselWall add_vessel_walls(geometry::PointCloud& cloud, std::vector<bool>& seen,
                            const Basin& basin, double spacing, double least_thickness) {
  OppositePoints opposite(cloud);
  VesselWall wall;
  std::vector<double> distances;
  double upper = 0;
  const std::size_t step = 1 + cloud.size() / kMostWallPoints;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (!basin.lines[i]) continue;
    if (basin.grid.height_of(cloud.points[i]) < basin.rim - 0.5 * basin.depth) continue;
    upper += 1;
    double nearest = std::numeric_limits<double>::infinity();
    opposite.visit(i, kThickest, 1.5 * spacing, [&](std::size_t j, double behind) {
      if (!basin.lines[j] && std::abs(behind) < std::abs(nearest)) nearest = behind;
    });
    if (std::isfinite(nearest)) distances.push_back(nearest);
  }
  wall.measured = static_cast<double>(distances.size()) > kLeastPaired * upper;
  wall.thickness = std::max(
      least_thickness, wall.measured ? wall_distance(std::move(distances)) : kAssumedThickness);

  // What was seen of a wall decides; where neither side was, the predicted inside.
  const double reach = 2.5 * wall.thickness;
  std::vector<bool> on_wall(cloud.size());
  std::vector<bool> gone(cloud.size());
  const auto decide = [&](std::size_t i) {
    const bool inside = basin.lines[i];
    if (!inside && !water_behind(basin, cloud.points[i], cloud.normals[i], wall.thickness)) return;
    bool other_side_stays = false;
    std::vector<std::size_t> predicted;
    opposite.visit(i, reach, wall.thickness, [&](std::size_t j, double) {
      if (basin.lines[j] == inside || gone[j]) return;
      if (seen[j] || on_wall[j]) {
        other_side_stays = true;
      } else {
        predicted.push_back(j);
      }
    });
    if (other_side_stays) return;
    on_wall[i] = true;
    for (const std::size_t j : predicted) gone[j] = true;
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (seen[i]) decide(i);
  }
  for (const bool inside : {true, false}) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!seen[i] && !gone[i] && basin.lines[i] == inside) decide(i);
    }
  }

  geometry::PointCloud walls;
  std::vector<bool> is_seen;
  const auto add = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& n, bool was_seen) {
    walls.points.push_back(p);
    walls.normals.push_back(n);
    is_seen.push_back(was_seen);
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!gone[i]) add(cloud.points[i], cloud.normals[i], seen[i]);
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!on_wall[i] || gone[i]) continue;
    const Eigen::Vector3f p =
        cloud.points[i] - static_cast<float>(wall.thickness) * cloud.normals[i];
    // A floor that is no higher than a wall is thick lies on the table.
    const bool is_floor = cloud.normals[i].cast<double>().dot(basin.grid.table.normal) > kLooksUp;
    if (basin.grid.height_of(p) < (is_floor ? wall.thickness : 0.0)) continue;
    add(p, -cloud.normals[i], false);
  }
  for (const geometry::PointCloud& missing : {missing_walls(walls, basin, spacing, wall.thickness),
                                              missing_floor(basin, spacing, wall.thickness)}) {
    for (std::size_t i = 0; i < missing.size(); ++i) {
      add(missing.points[i], missing.normals[i], false);
    }
  }
  cloud = std::move(walls);
  seen = std::move(is_seen);
  return wall;
}

}  // namespace prehend::surface
