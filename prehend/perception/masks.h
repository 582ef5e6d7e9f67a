#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/perception/segmented_scene.h"

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

/// A rectangle of pixels, all limits inclusive.
struct PixelRectangle {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
};

/// The part of the image in which the sensor measures: many depth images have a frame without any
/// value. Where at least 30 % of the rows (columns) begin within 4 pixels of the outermost one, the
/// area begins 4 pixels inside of that; otherwise at the image's own side.
PixelRectangle measured_area(const geometry::DepthImage& depth);

/// Whether any of the mask's pixels is within `margin` pixels of the area's border or beyond it.
bool touches_border(const geometry::MaskImage& mask, const PixelRectangle& area, int margin);

/// Fills in `occluded_share` and `nearer` of the scene's objects by their masks and its depth: of
/// the mask's outline pixels the share that has, within 4 pixels, a pixel of another mask that is
/// nearer by more than 10 mm. There the object goes on behind the other. O(pixels * objects).
void find_occlusions(SegmentedScene& scene);

}  // namespace prehend::perception
