#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"

// Pictures with fewer pixels, and the camera that would have taken them: n x n pixels become one.
// Columns and rows that fill no whole pixel are left out at the right and below. n = 1 changes
// nothing. All throw std::invalid_argument unless n is 1 or more, and geometry::InputError when
// nothing of the picture is left.
namespace prehend::perception {

/// Mean of the n x n pixels, which is what a sensor with larger pixels would see.
geometry::ColorImage binned(const geometry::ColorImage& image, int n);
geometry::Image<std::uint8_t> binned(const geometry::Image<std::uint8_t>& image, int n);

/// One of the n x n depths [m]: their median, of an even number the nearer one, so that no depth
/// comes out between a body and what is behind it. NaN where half of them or more are unknown.
geometry::DepthImage binned(const geometry::DepthImage& depth, int n);

/// Of an organized cloud in the camera's frame, which of its points stay: of each n x n that one
/// whose depth binned() gives; -1 where it gives none. Row by row, as many as binned() has pixels.
std::vector<int> binned_points(const geometry::PointCloud& cloud_C, int n);
/// Those points, organized, with their colours and normals. @pre cloud_C.organized()
geometry::PointCloud binned(const geometry::PointCloud& cloud_C, int n);

/// The n by which about so many of its points stay, the nearest whole number, of an organized cloud
/// that has more; else, and for points <= 0, 1.
int binning_to(const geometry::PointCloud& cloud, int points);

/// A pixel covers n x n of before: focal length, principal point and size change, what is seen of
/// a pixel's direction does not.
geometry::PinholeCamera binned(const geometry::PinholeCamera& camera, int n);
geometry::StereoCamera binned(const geometry::StereoCamera& camera, int n);

}  // namespace prehend::perception
