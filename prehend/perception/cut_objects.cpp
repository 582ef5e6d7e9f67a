#include "prehend/perception/cut_objects.h"

#include <algorithm>

#include "prehend/perception/cloud_partition.h"

namespace prehend::perception {
namespace {

using geometry::PinholeCamera;
using geometry::PointCloud;

bool is_at_max_height(const Eigen::Vector3d& p_C, const Table& table,
                      const SegmentationOptions& options) {
  constexpr double kStrip = 0.01;  // m
  return table.plane_C.signed_distance(p_C) > options.max_height - kStrip;
}

bool is_at_right_images_end(const PointCloud& cloud_C, int i, const PinholeCamera& camera,
                            const SegmentationOptions& options) {
  constexpr double kFrame = 5;  // pixels, that matching needs about it
  if (options.baseline <= 0 || !cloud_C.organized()) return false;
  const double disparity = camera.fx * options.baseline / cloud_C.points[i].z();
  return i % cloud_C.width - disparity < kFrame;
}

bool is_at_frame(const PointCloud& cloud_C, int i) {
  constexpr int kFrame = 3;  // pixels
  const int u = i % cloud_C.width, v = i / cloud_C.width;
  return u < kFrame || v < kFrame || u >= cloud_C.width - kFrame || v >= cloud_C.height - kFrame;
}

}  // namespace

bool goes_on(const PointCloud& cloud_C, const std::vector<int>& members,
             const PinholeCamera& camera, const Table& table, const SegmentationOptions& options) {
  constexpr double kStrip = 0.01;  // m
  std::vector<Eigen::Vector3f> corners;
  for (const Eigen::Vector3d& p : table.hull_C) corners.push_back(p.cast<float>());
  const PlaneOutline outline(table.plane_C, corners);
  std::size_t at_border = 0;
  for (const int i : members) {
    const Eigen::Vector3d p = cloud_C.points[i].cast<double>();
    at_border += is_at_max_height(p, table, options) ||
                 !outline.contains(p, options.hull_margin - kStrip) ||
                 (cloud_C.organized() &&
                  (is_at_frame(cloud_C, i) || is_at_right_images_end(cloud_C, i, camera, options)));
  }
  return at_border > 0 && 100 * at_border >= members.size();
}

bool is_cut_above(const PointCloud& cloud_C, const std::vector<int>& members, const Table& table,
                  const SegmentationOptions& options) {
  std::size_t at_top = 0;
  for (const int i : members) {
    at_top += is_at_max_height(cloud_C.points[i].cast<double>(), table, options);
  }
  return at_top > 0 && 100 * at_top >= members.size();
}

bool is_cut_by_right_image(const PointCloud& cloud_C, const std::vector<int>& members,
                           const PinholeCamera& camera, const SegmentationOptions& options) {
  constexpr int kLeastPoints = 20;
  return std::count_if(members.begin(), members.end(), [&](int i) {
           return is_at_right_images_end(cloud_C, i, camera, options);
         }) >= kLeastPoints;
}

}  // namespace prehend::perception
