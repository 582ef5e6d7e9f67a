#include "prehend/perception/segmentation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "prehend/perception/cloud_partition.h"
#include "prehend/perception/masks.h"
#include "prehend/perception/organized_components.h"
#include "prehend/text/require.h"

namespace prehend::perception {
namespace {

using geometry::Plane;
using geometry::PointCloud;
using geometry::RigidTransform;

constexpr int kMinClusterVoxels = 5;     // smaller ones are noise
constexpr double kOccludingStep = 0.01;  // m by which what hides an object is nearer

void check_options(const SegmentationOptions& o) {
  const text::Require require{"SegmentationOptions: "};
  require(std::isfinite(o.min_height) && o.min_height > 0, "min_height must be positive");
  require(o.max_height > o.min_height, "max_height must exceed min_height");
  require(o.max_distance > 0, "max_distance must be positive");
  require(std::isfinite(o.cluster_tolerance) && o.cluster_tolerance > 0,
          "cluster_tolerance must be positive");
  require(o.leaf_size >= 0 && o.leaf_size < o.cluster_tolerance,
          "leaf_size must be 0 or more and under cluster_tolerance");
  require(o.min_points > 0, "min_points must be positive");
  require(o.pixel_reach >= 1 && o.pixel_reach <= 20, "pixel_reach must be 1..20");
  require(o.min_object_height >= 0, "min_object_height must not be negative");
  require(std::isfinite(o.hull_margin), "hull_margin must be finite");
  require(o.close_radius >= 0 && o.close_radius <= 50, "close_radius must be 0..50");
  require(o.max_objects > 0, "max_objects must be positive");
  require(o.parts.contact_height >= 0 && o.parts.join_gap >= 0 && o.parts.drop_height >= 0,
          "parts must not have negative lengths");
}

std::vector<int> points_over_table(const PointCloud& cloud_C, const Table& table,
                                   const SegmentationOptions& options) {
  std::vector<Eigen::Vector3f> corners;
  for (const Eigen::Vector3d& p : table.hull_C) corners.push_back(p.cast<float>());
  const PlaneOutline outline(table.plane_C, corners);
  std::vector<int> indices;
  for (std::size_t i = 0; i < cloud_C.size(); ++i) {
    if (!geometry::is_finite(cloud_C.points[i])) continue;
    const Eigen::Vector3d p = cloud_C.points[i].cast<double>();
    const double height = table.plane_C.signed_distance(p);
    const double noise_growth = std::clamp(p.z() * p.z(), 1.0, 4.0);
    if (height >= options.min_height * noise_growth && height <= options.max_height &&
        p.norm() <= options.max_distance && outline.contains(p, options.hull_margin)) {
      indices.push_back(static_cast<int>(i));
    }
  }
  return indices;
}

// Clusters of the points over the table: voxels and which of them are together.
struct ClusteredVoxels {
  VoxelGrid grid;
  std::vector<std::vector<int>> clusters;  // indices of voxels
};

ClusteredVoxels cluster(const PointCloud& cloud_C, const std::vector<int>& indices,
                        const SegmentationOptions& options) {
  ClusteredVoxels result;
  if (options.clustering == Clustering::kEuclidean || !cloud_C.organized()) {
    result.grid = make_voxel_grid(cloud_C.points, indices, options.leaf_size);
    result.clusters =
        euclidean_clusters(result.grid.centroids, options.cluster_tolerance, kMinClusterVoxels);
    return result;
  }
  for (const std::vector<int>& component : organized_components(
           cloud_C, indices, options.cluster_tolerance, options.pixel_reach, kMinClusterVoxels)) {
    VoxelGrid grid = make_voxel_grid(cloud_C.points, component, options.leaf_size);
    const auto first = static_cast<int>(result.grid.centroids.size());
    std::vector<int>& voxels = result.clusters.emplace_back(grid.centroids.size());
    std::iota(voxels.begin(), voxels.end(), first);
    result.grid.centroids.insert(result.grid.centroids.end(), grid.centroids.begin(),
                                 grid.centroids.end());
    std::move(grid.members.begin(), grid.members.end(), std::back_inserter(result.grid.members));
  }
  return result;
}

bool is_object(const PointCloud& cloud_C, const std::vector<int>& members, const Table& table,
               const SegmentationOptions& options) {
  if (static_cast<int>(members.size()) < options.min_points) return false;
  // A stray point is no height.
  std::vector<double> heights;
  for (const int i : members) {
    heights.push_back(table.plane_C.signed_distance(cloud_C.points[i].cast<double>()));
  }
  const auto high = heights.end() - 1 - static_cast<std::ptrdiff_t>(heights.size() / 200);
  std::nth_element(heights.begin(), high, heights.end());
  return *high >= options.min_object_height;
}

// Point indices of each object, largest first.
std::vector<std::vector<int>> find_objects(const PointCloud& cloud_C,
                                           const geometry::PinholeCamera& camera,
                                           const Table& table, const SegmentationOptions& options) {
  const ClusteredVoxels voxels =
      cluster(cloud_C, points_over_table(cloud_C, table, options), options);
  std::vector<std::vector<int>> objects;
  for (const auto& part :
       joined_parts(voxels.grid.centroids, voxels.clusters, table.plane_C, options.parts)) {
    std::vector<int> members;
    for (const int voxel : part) {
      const std::vector<int>& points = voxels.grid.members[voxel];
      members.insert(members.end(), points.begin(), points.end());
    }
    std::sort(members.begin(), members.end());
    if (!is_object(cloud_C, members, table, options)) continue;
    if (!options.split || !cloud_C.organized()) {
      objects.push_back(std::move(members));
      continue;
    }
    for (auto& piece : split_touching(cloud_C, camera, members, options.splitting)) {
      if (is_object(cloud_C, piece, table, options)) objects.push_back(std::move(piece));
    }
  }
  std::sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  if (objects.size() > static_cast<std::size_t>(options.max_objects)) {
    objects.resize(static_cast<std::size_t>(options.max_objects));
  }
  return objects;
}

// Mean of all objects' points, else of the table.
Eigen::Vector3d anchor_of(const PointCloud& cloud_C, const std::vector<std::vector<int>>& objects,
                          const Table& table) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const auto& members : objects) {
    for (const int i : members) sum += cloud_C.points[i].cast<double>();
    count += static_cast<double>(members.size());
  }
  if (count > 0) return sum / count;
  for (const Eigen::Vector3d& p : table.hull_C) sum += p;
  return table.hull_C.empty() ? Eigen::Vector3d(0, 0, 1)
                              : Eigen::Vector3d(sum / static_cast<double>(table.hull_C.size()));
}

Plane transformed(const Plane& plane_B, const RigidTransform& X_AB) {
  Plane plane_A;
  plane_A.normal = X_AB.linear() * plane_B.normal;
  plane_A.offset = plane_B.offset + plane_A.normal.dot(X_AB.translation());
  return plane_A;
}

}  // namespace

RigidTransform world_from_table(const Plane& table_C, const Eigen::Vector3d& anchor_C) {
  const Eigen::Vector3d z = table_C.normal.normalized();
  Eigen::Vector3d x = Eigen::Vector3d::UnitX() - z.x() * z;
  // A camera whose x axis stands on the table: take the viewing direction.
  if (x.norm() < 1e-3) x = Eigen::Vector3d::UnitZ() - z.z() * z;
  x.normalize();
  RigidTransform X_CW = RigidTransform::Identity();
  X_CW.linear() << x, z.cross(x), z;
  X_CW.translation() = table_C.project(anchor_C);
  return X_CW.inverse();
}

SegmentedScene segment_on_table(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                                const Table& table, const std::optional<RigidTransform>& X_WC,
                                const SegmentationOptions& options) {
  check_options(options);
  if (camera.width <= 0 || camera.height <= 0 ||
      (cloud_C.organized() && (cloud_C.width != camera.width || cloud_C.height != camera.height))) {
    throw std::invalid_argument("segment_on_table: the camera's size is not the cloud's");
  }
  const std::vector<std::vector<int>> members = find_objects(cloud_C, camera, table, options);
  ObjectImages images = draw_objects(cloud_C, camera, members, options.close_radius);

  SegmentedScene scene;
  scene.camera = camera;
  scene.X_WC = X_WC ? *X_WC : world_from_table(table.plane_C, anchor_of(cloud_C, members, table));
  scene.depth = std::move(images.depth);
  scene.table_W = transformed(table.plane_C, scene.X_WC);
  // An organized cloud is what the sensor measured; a virtual camera's image has no frame.
  const PixelRectangle area = cloud_C.organized()
                                  ? measured_area(scene.depth)
                                  : PixelRectangle{0, 0, camera.width - 1, camera.height - 1};
  const int margin = cloud_C.organized() ? options.close_radius + 1 : 0;
  const std::vector<double> occluded =
      occluded_shares(images.masks, scene.depth, options.close_radius + 2, kOccludingStep);
  for (std::size_t k = 0; k < members.size(); ++k) {
    ObjectHypothesis object;
    object.id = static_cast<int>(k);
    object.cloud_W = geometry::transformed(geometry::select(cloud_C, members[k]), scene.X_WC);
    object.occluded_share = occluded[k];
    object.mask = std::move(images.masks[k]);
    object.touches_image_border = touches_border(object.mask, area, margin);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

SegmentedScene segment(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                       const std::optional<RigidTransform>& X_WC,
                       const SegmentationOptions& options, const TableOptions& table_options) {
  std::optional<Eigen::Vector3d> up_C;
  if (X_WC) up_C = X_WC->linear().transpose() * Eigen::Vector3d::UnitZ();
  const Table table = find_table(cloud_C, table_options, up_C);
  return segment_on_table(cloud_C, camera, table, X_WC, options);
}

}  // namespace prehend::perception
