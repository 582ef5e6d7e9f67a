#include "prehend/perception/cloud_partition.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
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

// Points one after the other in the same voxel, as the neighbours of an image mostly are. Voxels
// compare as their coordinates z, y, x do; runs of one by their points.
struct VoxelRun {
  std::uint64_t high = 0, low = 0;  // coordinates of 42 bits each, z first
  int first = 0, last = 0;          // of the indices, without `last`

  bool same_voxel(const VoxelRun& other) const { return high == other.high && low == other.low; }
  bool operator<(const VoxelRun& other) const {
    if (high != other.high) return high < other.high;
    return low != other.low ? low < other.low : first < other.first;
  }
};

constexpr std::int64_t kVoxelRange = std::int64_t{1} << 41;  // to both sides of the origin

std::uint64_t voxel_coordinate(double scaled) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(scaled)) + kVoxelRange);
}

std::vector<VoxelRun> sorted_runs(const std::vector<Eigen::Vector3f>& points,
                                  const std::vector<int>& ascending, double leaf_size) {
  std::vector<VoxelRun> runs;
  for (int k = 0; k < static_cast<int>(ascending.size()); ++k) {
    const Eigen::Vector3d scaled = points[ascending[k]].cast<double>() / leaf_size;
    const std::uint64_t y = voxel_coordinate(scaled.y());
    const VoxelRun run{voxel_coordinate(scaled.z()) << 21 | y >> 21,
                       (y & 0x1fffff) << 42 | voxel_coordinate(scaled.x()), k, k + 1};
    if (!runs.empty() && runs.back().same_voxel(run)) {
      runs.back().last = run.last;
    } else {
      runs.push_back(run);
    }
  }
  std::sort(runs.begin(), runs.end());
  return runs;
}

// Calls `take` with the mean of each voxel and the runs of its points.
template <class Take>
void for_each_voxel(const std::vector<Eigen::Vector3f>& points, const std::vector<int>& ascending,
                    double leaf_size, const Take& take) {
  const std::vector<VoxelRun> runs = sorted_runs(points, ascending, leaf_size);
  for (auto first = runs.begin(); first != runs.end();) {
    auto last = first;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (; last != runs.end() && last->same_voxel(*first); ++last) {
      for (int k = last->first; k < last->last; ++k) sum += points[ascending[k]].cast<double>();
      count += last->last - last->first;
    }
    take(Eigen::Vector3f((sum / static_cast<double>(count)).cast<float>()), first, last, count);
    first = last;
  }
}

std::vector<int> in_ascending_order(std::vector<int> indices) {
  if (!std::is_sorted(indices.begin(), indices.end())) std::sort(indices.begin(), indices.end());
  return indices;
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
  const std::vector<int> ascending = in_ascending_order(indices);
  for_each_voxel(points, ascending, leaf_size,
                 [&](const Eigen::Vector3f& mean, auto first, auto last, int count) {
                   grid.centroids.push_back(mean);
                   std::vector<int>& members = grid.members.emplace_back();
                   members.reserve(static_cast<std::size_t>(count));
                   for (; first != last; ++first) {
                     members.insert(members.end(), ascending.begin() + first->first,
                                    ascending.begin() + first->last);
                   }
                 });
  return grid;
}

std::vector<Eigen::Vector3f> voxel_centroids(const std::vector<Eigen::Vector3f>& points,
                                             const std::vector<int>& indices, double leaf_size) {
  std::vector<Eigen::Vector3f> centroids;
  if (leaf_size <= 0) {
    for (const int i : indices) centroids.push_back(points[i]);
    return centroids;
  }
  for_each_voxel(points, in_ascending_order(indices), leaf_size,
                 [&](const Eigen::Vector3f& mean, auto, auto, int) { centroids.push_back(mean); });
  return centroids;
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
    center_ += corners_[i] / static_cast<double>(corners_.size());
  }
  inner_ = std::numeric_limits<double>::infinity();
  for (const Side& side : sides_) {
    if (side.length > 0) {
      inner_ = std::min(inner_, cross(side.edge, center_ - side.corner) / side.length);
    }
  }
}

Eigen::Vector2d PlaneOutline::flat(const Eigen::Vector3d& p) const {
  return {x_.dot(p), y_.dot(p)};
}

bool PlaneOutline::contains(const Eigen::Vector3d& p, double margin) const {
  const Eigen::Vector2d q = flat(p);
  // By a hair less, as the sides' distances are rounded.
  if (margin >= 0 && (q - center_).norm() < inner_ - 1e-9) return true;
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
