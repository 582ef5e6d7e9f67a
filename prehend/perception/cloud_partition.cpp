#include "prehend/perception/cloud_partition.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include <pcl/PointIndices.h>
#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/surface/convex_hull.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

pcl::PointCloud<pcl::PointXYZ>::Ptr to_pcl(const std::vector<Eigen::Vector3f>& points) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(points.size());
  for (const Eigen::Vector3f& p : points) cloud->emplace_back(p.x(), p.y(), p.z());
  return cloud;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// A point's voxel. Voxels compare as their coordinates z, y, x do; points of one by their indices.
struct VoxelEntry {
  std::uint64_t high = 0, low = 0;  // coordinates of 42 bits each, z first
  int index = 0;

  bool same_voxel(const VoxelEntry& other) const { return high == other.high && low == other.low; }
  bool operator<(const VoxelEntry& other) const {
    if (high != other.high) return high < other.high;
    return low != other.low ? low < other.low : index < other.index;
  }
};

constexpr std::int64_t kVoxelRange = std::int64_t{1} << 41;  // to both sides of the origin

std::uint64_t voxel_coordinate(double scaled) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(scaled)) + kVoxelRange);
}

std::vector<VoxelEntry> sorted_entries(const std::vector<Eigen::Vector3f>& points,
                                       const std::vector<int>& indices, double leaf_size) {
  std::vector<VoxelEntry> entries;
  entries.reserve(indices.size());
  for (const int i : indices) {
    const Eigen::Vector3d scaled = points[i].cast<double>() / leaf_size;
    const std::uint64_t y = voxel_coordinate(scaled.y());
    entries.push_back({voxel_coordinate(scaled.z()) << 21 | y >> 21,
                       (y & 0x1fffff) << 42 | voxel_coordinate(scaled.x()), i});
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

}  // namespace

VoxelGrid make_voxel_grid(const std::vector<Eigen::Vector3f>& points,
                          const std::vector<int>& indices, double leaf_size) {
  VoxelGrid grid;
  if (leaf_size <= 0) {
    for (const int i : indices) {
      grid.centroids.push_back(points[i]);
      grid.members.push_back({i});
    }
    return grid;
  }
  const std::vector<VoxelEntry> entries = sorted_entries(points, indices, leaf_size);
  for (std::size_t first = 0; first < entries.size();) {
    std::size_t last = first;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::vector<int> members;
    for (; last < entries.size() && entries[last].same_voxel(entries[first]); ++last) {
      sum += points[entries[last].index].cast<double>();
      members.push_back(entries[last].index);
    }
    grid.centroids.push_back((sum / static_cast<double>(last - first)).cast<float>());
    grid.members.push_back(std::move(members));
    first = last;
  }
  return grid;
}

void silence_pcl() { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }

std::vector<std::vector<int>> euclidean_clusters(const std::vector<Eigen::Vector3f>& points,
                                                 double tolerance, int min_size) {
  if (points.empty()) return {};
  silence_pcl();
  const auto cloud = to_pcl(points);
  const auto tree = pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false);
  tree->setInputCloud(cloud);
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setInputCloud(cloud);
  extraction.setSearchMethod(tree);
  extraction.setClusterTolerance(tolerance);
  extraction.setMinClusterSize(min_size);
  std::vector<pcl::PointIndices> groups;
  extraction.extract(groups);
  std::vector<std::vector<int>> clusters;
  for (pcl::PointIndices& group : groups) {
    std::sort(group.indices.begin(), group.indices.end());
    clusters.emplace_back(group.indices.begin(), group.indices.end());
  }
  std::sort(clusters.begin(), clusters.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  return clusters;
}

PlaneOutline::PlaneOutline(const geometry::Plane& plane, const std::vector<Eigen::Vector3f>& points)
    : plane_(plane), x_(plane.normal.unitOrthogonal()), y_(plane.normal.cross(x_)) {
  std::vector<Eigen::Vector3f> flattened;
  Eigen::AlignedBox2d box;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector2d q = flat(p.cast<double>());
    flattened.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()), 0.0F);
    box.extend(q);
    mean += q / static_cast<double>(points.size());
  }
  for (const Eigen::Vector3f& f : flattened) {
    const Eigen::Vector2d d = f.head<2>().cast<double>() - mean;
    scatter += d * d.transpose();
  }
  // Qhull aborts on points without area.
  const double spread = std::max(scatter.trace(), 1e-300);
  if (points.size() < 3 || scatter.determinant() < 1e-10 * spread * spread) {
    throw geometry::InputError("The points of a plane are on a line, so it has no outline",
                               "Pass a cloud with a table");
  }
  silence_pcl();
  pcl::ConvexHull<pcl::PointXYZ> hull;
  hull.setInputCloud(to_pcl(flattened));
  hull.setDimension(2);
  pcl::PointCloud<pcl::PointXYZ> corners;
  hull.reconstruct(corners);
  for (const pcl::PointXYZ& c : corners) corners_.emplace_back(c.x, c.y);
  double area_twice = 0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    area_twice += cross(corners_[i], corners_[(i + 1) % corners_.size()]);
  }
  if (area_twice < 0) std::reverse(corners_.begin(), corners_.end());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Eigen::Vector2d edge = corners_[(i + 1) % corners_.size()] - corners_[i];
    sides_.push_back({corners_[i], edge, edge.norm()});
  }
}

Eigen::Vector2d PlaneOutline::flat(const Eigen::Vector3d& p) const {
  return {x_.dot(p), y_.dot(p)};
}

bool PlaneOutline::contains(const Eigen::Vector3d& p, double margin) const {
  const Eigen::Vector2d q = flat(p);
  for (const Side& side : sides_) {
    if (cross(side.edge, q - side.corner) < -margin * side.length) return false;
  }
  return true;
}

std::vector<Eigen::Vector3d> PlaneOutline::vertices() const {
  std::vector<Eigen::Vector3d> result;
  for (const Eigen::Vector2d& c : corners_) {
    result.push_back(plane_.offset * plane_.normal + c.x() * x_ + c.y() * y_);
  }
  return result;
}

double PlaneOutline::area() const {
  double twice = 0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    twice += cross(corners_[i], corners_[(i + 1) % corners_.size()]);
  }
  return 0.5 * twice;
}

}  // namespace prehend::perception
