#include "prehend/perception/masks.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/perception/stereo.h"
#include "prehend/perception/virtual_camera.h"

namespace prehend::perception {
namespace {

constexpr int kFrameTolerance = 4;      // pixels: frames are a little skewed
constexpr double kStraightShare = 0.3;  // of a side's rows or columns

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
    const geometry::Image<int> nearest = splat(cloud_C, camera, 1.5 * point_spacing(cloud_C));
    images.depth =
        geometry::DepthImage(camera.width, camera.height, std::numeric_limits<float>::quiet_NaN());
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

PixelRectangle measured_area(const geometry::DepthImage& depth) {
  const int width = depth.width, height = depth.height;
  // First and last known pixel of each row and column; an empty one has first > last.
  std::vector<int> row_first(height, width), row_last(height, -1);
  std::vector<int> column_first(width, height), column_last(width, -1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (!std::isfinite(depth.at(u, v))) continue;
      row_first[v] = std::min(row_first[v], u);
      row_last[v] = u;
      column_first[u] = std::min(column_first[u], v);
      column_last[u] = v;
    }
  }
  // `inwards` is +1 for sides where coordinates grow into the image.
  const auto straight_or = [](const std::vector<int>& ends, int extreme, int inwards,
                              int image_side) {
    const auto near = std::count_if(ends.begin(), ends.end(), [extreme](int end) {
      return std::abs(end - extreme) <= kFrameTolerance;
    });
    const bool straight = near >= kStraightShare * static_cast<double>(ends.size());
    return straight ? extreme + inwards * kFrameTolerance : image_side;
  };
  PixelRectangle area{0, 0, width - 1, height - 1};
  if (*std::max_element(row_last.begin(), row_last.end()) < 0) return area;  // nothing is known
  area.left = straight_or(row_first, *std::min_element(row_first.begin(), row_first.end()), 1, 0);
  area.right =
      straight_or(row_last, *std::max_element(row_last.begin(), row_last.end()), -1, width - 1);
  area.top =
      straight_or(column_first, *std::min_element(column_first.begin(), column_first.end()), 1, 0);
  area.bottom = straight_or(column_last, *std::max_element(column_last.begin(), column_last.end()),
                            -1, height - 1);
  return area;
}

bool touches_border(const geometry::MaskImage& mask, const PixelRectangle& area, int margin) {
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) != 0 && (u <= area.left + margin || u >= area.right - margin ||
                                 v <= area.top + margin || v >= area.bottom - margin)) {
        return true;
      }
    }
  }
  return false;
}

namespace {

/// Which object each pixel belongs to, by index; -1: none.
geometry::Image<int> owners(const SegmentedScene& scene) {
  geometry::Image<int> owner(scene.camera.width, scene.camera.height, -1);
  for (std::size_t k = 0; k < scene.objects.size(); ++k) {
    const geometry::MaskImage& mask = scene.objects[k].mask;
    for (std::size_t i = 0; i < owner.data.size(); ++i) {
      if (mask.data[i] != 0) owner.data[i] = static_cast<int>(k);
    }
  }
  return owner;
}

}  // namespace

void find_occlusions(SegmentedScene& scene) {
  constexpr int kReach = 4;          // pixels
  constexpr float kStep = 0.01f;     // m by which what hides an object is nearer
  constexpr int kLeastContacts = 5;  // pixels
  const geometry::DepthImage& depth = scene.depth;
  const std::size_t pixels =
      static_cast<std::size_t>(scene.camera.width) * static_cast<std::size_t>(scene.camera.height);
  const std::size_t n = scene.objects.size();
  if (n < 2 || depth.data.size() != pixels) return;
  const geometry::Image<int> owner = owners(scene);
  std::vector<double> outline(n, 0), hidden(n, 0);
  std::vector<std::vector<int>> contacts(n, std::vector<int>(n, 0));  // object x what is before it
  std::vector<float> farthest(n, 0);                                  // m
  for (int v = 0; v < owner.height; ++v) {
    for (int u = 0; u < owner.width; ++u) {
      const int own = owner.at(u, v);
      if (own < 0) continue;
      farthest[own] = std::max(farthest[own], depth.at(u, v));
      const auto is_other = [&](int du, int dv) {
        return !owner.contains(u + du, v + dv) || owner.at(u + du, v + dv) != own;
      };
      if (!is_other(1, 0) && !is_other(-1, 0) && !is_other(0, 1) && !is_other(0, -1)) continue;
      outline[own] += 1;
      int before = -1;
      for (int dv = -kReach; dv <= kReach && before < 0; ++dv) {
        for (int du = -kReach; du <= kReach && before < 0; ++du) {
          if (!owner.contains(u + du, v + dv)) continue;
          const int other = owner.at(u + du, v + dv);
          const float at = depth.at(u + du, v + dv);
          if (other >= 0 && other != own && at > 0 && depth.at(u, v) - at > kStep) before = other;
        }
      }
      if (before < 0) continue;
      hidden[own] += 1;
      ++contacts[own][before];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    ObjectHypothesis& object = scene.objects[k];
    object.occluded_share = hidden[k] / std::max(outline[k], 1.0);
    object.nearer = {};
    for (std::size_t i = 0; i < pixels; ++i) {
      const int other = owner.data[i];
      if (other < 0 || contacts[k][other] < kLeastContacts || !(depth.data[i] > 0) ||
          depth.data[i] > farthest[k]) {
        continue;
      }
      if (object.nearer.data.empty()) {
        object.nearer = geometry::DepthImage(owner.width, owner.height, 0.f);
      }
      object.nearer.data[i] = depth.data[i];
    }
  }
}

}  // namespace prehend::perception
