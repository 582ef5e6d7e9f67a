#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"

// From clusters of points to images of them.
namespace prehend::perception {

/// One mask per object. `members[k]` are the indices of object k's points in `cloud_C`.
struct ObjectImages {
  std::vector<geometry::MaskImage> masks;  // of the camera's size
  geometry::DepthImage depth;
};

/// Organized clouds: pixel membership. Others: splats of the cloud's own spacing, nearest wins.
/// Masks are closed with a disc of `close_radius` pixels, but never over another object's pixel.
ObjectImages draw_objects(const geometry::PointCloud& cloud_C,
                          const geometry::PinholeCamera& camera,
                          const std::vector<std::vector<int>>& members, int close_radius);

/// Whether any of the mask's pixels is in the outermost row or column.
bool touches_border(const geometry::MaskImage& mask);

}  // namespace prehend::perception
