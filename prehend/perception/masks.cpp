#include "prehend/perception/masks.h"

#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/perception/stereo.h"
#include "prehend/perception/virtual_camera.h"

namespace prehend::perception {
namespace {

cv::Mat view(geometry::MaskImage& mask) {
  return {mask.height, mask.width, CV_8UC1, mask.data.data()};
}

void close_holes(geometry::MaskImage& mask, const geometry::Image<int>& owner, int self,
                 int radius) {
  if (radius <= 0) return;
  const int side = 2 * radius + 1;
  const cv::Mat disc =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(side, side), cv::Point(radius, radius));
  cv::Mat image = view(mask);
  cv::morphologyEx(image, image, cv::MORPH_CLOSE, disc);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    if (owner.data[i] >= 0 && owner.data[i] != self) mask.data[i] = 0;
  }
}

}  // namespace

ObjectImages draw_objects(const geometry::PointCloud& cloud_C,
                          const geometry::PinholeCamera& camera,
                          const std::vector<std::vector<int>>& members, int close_radius) {
  ObjectImages images;
  std::vector<int> object_of(cloud_C.size(), -1);
  for (std::size_t k = 0; k < members.size(); ++k) {
    for (const int i : members[k]) object_of[i] = static_cast<int>(k);
  }
  geometry::Image<int> owner(camera.width, camera.height, -1);
  if (cloud_C.organized()) {
    owner.data = object_of;
    images.depth = depth_of(cloud_C);
  } else {
    const geometry::Image<int> nearest =
        splat(cloud_C, camera, 1.5 * point_spacing(cloud_C));
    images.depth = geometry::DepthImage(camera.width, camera.height,
                                        std::numeric_limits<float>::quiet_NaN());
    for (std::size_t i = 0; i < owner.data.size(); ++i) {
      if (nearest.data[i] < 0) continue;
      owner.data[i] = object_of[nearest.data[i]];
      images.depth.data[i] = cloud_C.points[nearest.data[i]].z();
    }
  }
  for (std::size_t k = 0; k < members.size(); ++k) {
    geometry::MaskImage mask(camera.width, camera.height);
    for (std::size_t i = 0; i < owner.data.size(); ++i) {
      if (owner.data[i] == static_cast<int>(k)) mask.data[i] = 255;
    }
    close_holes(mask, owner, static_cast<int>(k), close_radius);
    images.masks.push_back(std::move(mask));
  }
  return images;
}

bool touches_border(const geometry::MaskImage& mask) {
  for (int u = 0; u < mask.width; ++u) {
    if (mask.at(u, 0) != 0 || mask.at(u, mask.height - 1) != 0) return true;
  }
  for (int v = 0; v < mask.height; ++v) {
    if (mask.at(0, v) != 0 || mask.at(mask.width - 1, v) != 0) return true;
  }
  return false;
}

}  // namespace prehend::perception
