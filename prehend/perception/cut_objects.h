#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/perception/segmentation.h"

namespace prehend::perception {

/// Whether the points `members` (indices) of `cloud_C` are cut off by the image (of a stereo pair
/// by either), by max_height or by the end of the table: at least a hundredth of them is there.
bool goes_on(const geometry::PointCloud& cloud_C, const std::vector<int>& members,
             const geometry::PinholeCamera& camera, const Table& table,
             const SegmentationOptions& options);

/// Whether at least a hundredth of them is at max_height: higher points are dropped.
bool is_cut_above(const geometry::PointCloud& cloud_C, const std::vector<int>& members,
                  const Table& table, const SegmentationOptions& options);

/// Whether 20 or more of them are where the right image of the pair ends whose left one an
/// organized cloud is (SegmentationOptions::baseline): what is farther left was never measured.
bool is_cut_by_right_image(const geometry::PointCloud& cloud_C, const std::vector<int>& members,
                           const geometry::PinholeCamera& camera,
                           const SegmentationOptions& options);

}  // namespace prehend::perception
