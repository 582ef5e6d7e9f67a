#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/perception/table.h"

namespace prehend::perception {

/// As high as the noise of the table's points reaches [m]: options.min_height, or 3.5 times their
/// root mean square within 4 and 8 mm.
double least_height(const Table& table, const SegmentationOptions& options);

/// Of the noise at a depth [m], to that at 1 m and nearer: its square, at most 4.
double noise_growth(double depth);

struct PointsOverTable {
  std::vector<int> indices;  // of the cloud, ascending
  PointsLeftOut left_out;    // all others
};

/// The points that objects are made of: over the table's outline and its noise, within max_height
/// and max_distance, and of organized clouds no flying ones.
PointsOverTable points_over_table(const geometry::PointCloud& cloud_C,
                                  const geometry::PinholeCamera& camera, const Table& table,
                                  const SegmentationOptions& options);

}  // namespace prehend::perception
