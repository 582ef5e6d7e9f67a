#include "prehend/shape/seen_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::shape {
namespace {

using geometry::InputError;

/// The pixel that p projects to; empty (u = -1) beside the image or behind the camera.
struct Pixel {
  int u = -1;
  int v = -1;
};

Pixel pixel_of(const geometry::PinholeCamera& camera, const Eigen::Vector3d& p_C) {
  if (!(p_C.z() > 0)) return {};
  const Eigen::Vector2d pixel = camera.project(p_C);
  const double u = std::floor(pixel.x() + 0.5), v = std::floor(pixel.y() + 0.5);
  if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) return {};
  return {static_cast<int>(u), static_cast<int>(v)};
}

void check_camera(const ObjectView& view) {
  const auto& camera = view.camera;
  if (camera.width <= 0 || camera.height <= 0 || !(camera.fx > 0) || !(camera.fy > 0) ||
      !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy)) {
    throw InputError("the camera of the view has no valid size or focal length",
                     "give width, height, fx and fy > 0");
  }
  if (view.mask.width != camera.width || view.mask.height != camera.height ||
      view.mask.data.size() != static_cast<std::size_t>(camera.width) * camera.height) {
    throw InputError("the object's mask is " + std::to_string(view.mask.width) + " x " +
                         std::to_string(view.mask.height) + " pixels, the camera's image " +
                         std::to_string(camera.width) + " x " + std::to_string(camera.height),
                     "give a mask of the whole image");
  }
  if (view.nearer && !view.nearer->data.empty() &&
      (view.nearer->width != camera.width || view.nearer->height != camera.height)) {
    throw InputError("the depth of what is nearer is not of the camera's size",
                     "give it for the whole image, or none");
  }
  if (view.depth && !view.depth->empty() &&
      (view.depth->width != camera.width || view.depth->height != camera.height)) {
    throw InputError("the depth of the view is not of the camera's size",
                     "give it for the whole image, or none");
  }
  if (std::all_of(view.mask.data.begin(), view.mask.data.end(),
                  [](std::uint8_t pixel) { return pixel == 0; })) {
    throw InputError("the object's mask is empty", "segment the object again");
  }
}

bool touches_mask(const geometry::MaskImage& mask, const Pixel& pixel) {
  for (int v = pixel.v - 1; v <= pixel.v + 1; ++v) {
    for (int u = pixel.u - 1; u <= pixel.u + 1; ++u) {
      if (mask.contains(u, v) && mask.at(u, v) != 0) return true;
    }
  }
  return false;
}

void include(PixelWindow& window, const Pixel& pixel) {
  window.u0 = std::min(window.u0, pixel.u);
  window.v0 = std::min(window.v0, pixel.v);
  window.u1 = std::max(window.u1, pixel.u + 1);
  window.v1 = std::max(window.v1, pixel.v + 1);
}

PixelWindow whole_image(const geometry::PinholeCamera& camera) {
  return {0, 0, camera.width, camera.height};
}

PixelWindow window_of_mask_and_points(const ObjectView& view) {
  PixelWindow window{view.camera.width, view.camera.height, 0, 0};
  for (int v = 0; v < view.mask.height; ++v) {
    const std::uint8_t* row = &view.mask.at(0, v);
    const std::uint8_t* end = row + view.mask.width;
    const auto inside = [](std::uint8_t pixel) { return pixel != 0; };
    const std::uint8_t* first = std::find_if(row, end, inside);
    if (first == end) continue;
    const std::uint8_t* last = end - 1;
    while (*last == 0) --last;
    include(window, {static_cast<int>(first - row), v});
    include(window, {static_cast<int>(last - row), v});
  }
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    const Pixel pixel = pixel_of(view.camera, X_CW * p_W.cast<double>());
    if (pixel.u >= 0) include(window, pixel);
  }
  return window;
}

/// Squared pixels to the nearest depth in the same column, and that depth (the lesser of two).
struct ColumnNearest {
  std::vector<std::int32_t> squared;
  std::vector<float> depth;
};

ColumnNearest nearest_in_columns(const geometry::Image<float>& depth, float none) {
  constexpr std::int32_t kFar = 1 << 30;
  const int width = depth.width, height = depth.height;
  ColumnNearest result{std::vector<std::int32_t>(depth.data.size(), kFar),
                       std::vector<float>(depth.data.size(), none)};
  std::vector<int> last(width, -1);
  const auto sweep = [&](int v) {
    for (int u = 0; u < width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * width + u;
      if (depth.data[i] != none) last[u] = v;
      if (last[u] < 0) continue;
      const std::int32_t squared = (v - last[u]) * (v - last[u]);
      const float value = depth.at(u, last[u]);
      if (squared < result.squared[i] ||
          (squared == result.squared[i] && value < result.depth[i])) {
        result.squared[i] = squared;
        result.depth[i] = value;
      }
    }
  };
  for (int v = 0; v < height; ++v) sweep(v);
  std::fill(last.begin(), last.end(), -1);
  for (int v = height - 1; v >= 0; --v) sweep(v);
  return result;
}

/// The depth of the pixel nearest to (u, v) that has one, of equally near ones the least.
float nearest_depth(const ColumnNearest& columns, int width, int u, int v) {
  const std::size_t row = static_cast<std::size_t>(v) * width;
  std::int32_t best = std::numeric_limits<std::int32_t>::max();
  float value = std::numeric_limits<float>::infinity();
  for (int k = 0; k < width && k * k <= best; ++k) {
    for (const int w : {u - k, u + k}) {
      if (w < 0 || w >= width) continue;
      const std::int32_t squared = columns.squared[row + w] + k * k;
      if (squared < best || (squared == best && columns.depth[row + w] < value)) {
        best = squared;
        value = columns.depth[row + w];
      }
    }
  }
  return value;
}

geometry::Image<float> depth_in_window(const ObjectView& view, const PixelWindow& window,
                                       float none) {
  geometry::Image<float> depth(window.width(), window.height(), none);
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    const Pixel pixel = pixel_of(view.camera, p_C);
    if (pixel.u < 0) continue;
    float& value = depth.at(pixel.u - window.u0, pixel.v - window.v0);
    value = std::min(value, static_cast<float>(p_C.z()));
  }
  return depth;
}

}  // namespace

void check_view(const ObjectView& view) {
  check_camera(view);
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  std::size_t inside_mask = 0;
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    if (!geometry::is_finite(p_W)) {
      throw InputError("a seen point of the object is not finite", "remove invalid points");
    }
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    if (!(p_C.z() > 0)) {
      throw InputError("a seen point lies behind the camera",
                       "check the camera's pose; its optical frame looks along +z");
    }
    const Pixel pixel = pixel_of(view.camera, p_C);
    inside_mask += pixel.u >= 0 && touches_mask(view.mask, pixel);
  }
  if (2 * inside_mask < view.cloud_W.size()) {
    throw InputError("only " + std::to_string(inside_mask) + " of " +
                         std::to_string(view.cloud_W.size()) +
                         " seen points project into the object's mask",
                     "check that mask, camera and camera pose belong to the cloud");
  }
}

PointEvidence evidence_about(const SeenMap& map, const geometry::PinholeCamera& camera,
                             const Eigen::Vector3d& p_C, double depth_tolerance) {
  const auto ramp = [](double x) { return std::clamp(x - 0.5, 0.0, 1.0); };
  PointEvidence evidence;
  float value = 0;
  if (p_C.z() > 0) {
    const Eigen::Vector2d pixel = camera.project(p_C);
    const double u =
        std::clamp(std::floor(pixel.x() + 0.5), map.window.u0 - 1.0, map.window.u1 * 1.0);
    const double v =
        std::clamp(std::floor(pixel.y() + 0.5), map.window.v0 - 1.0, map.window.v1 * 1.0);
    value = map.at(static_cast<int>(u), static_cast<int>(v));
  }
  if (value == 0) {
    evidence.unseen = true;
  } else if (value < 0) {
    const double outside = -value * p_C.z() / (0.5 * (camera.fx + camera.fy));
    evidence.contradicted = ramp(outside / (0.5 * depth_tolerance));
  } else {
    const double before = value - p_C.z();
    evidence.contradicted = ramp(before / depth_tolerance);
    evidence.coincident = std::max(0.0, 1 - std::abs(before) / depth_tolerance);
    evidence.behind = std::max(0.0, -before);
  }
  return evidence;
}

PixelWindow window_of_mirrored(const ObjectView& view,
                               const std::vector<geometry::Plane>& planes_C) {
  PixelWindow window = window_of_mask_and_points(view);
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) box.extend(X_CW * p_W.cast<double>());
  for (const geometry::Plane& plane : planes_C) {
    std::array<Eigen::Vector3d, 8> corners;
    bool in_front = true;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
      corners[i] = corner - 2 * plane.signed_distance(corner) * plane.normal;
      in_front = in_front && corners[i].z() > 0;
    }
    if (!in_front) return whole_image(view.camera);
    for (const Eigen::Vector3d& corner : corners) {
      const Eigen::Vector2d pixel = view.camera.project(corner);
      // One pixel more: a corner may round to the other side than a point within.
      include(window, {static_cast<int>(std::clamp(pixel.x() - 1, 0.0, view.camera.width - 1.0)),
                       static_cast<int>(std::clamp(pixel.y() - 1, 0.0, view.camera.height - 1.0))});
      include(window, {static_cast<int>(std::clamp(pixel.x() + 2, 0.0, view.camera.width - 1.0)),
                       static_cast<int>(std::clamp(pixel.y() + 2, 0.0, view.camera.height - 1.0))});
    }
  }
  return window;
}

PixelWindow window_round_object(const ObjectView& view, double margin) {
  PixelWindow window = window_of_mask_and_points(view);
  const int more = static_cast<int>(margin * std::max(window.width(), window.height())) + 1;
  window.u0 = std::max(window.u0 - more, 0);
  window.v0 = std::max(window.v0 - more, 0);
  window.u1 = std::min(window.u1 + more, view.camera.width);
  window.v1 = std::min(window.v1 + more, view.camera.height);
  return window;
}

SeenMap make_seen_map(const ObjectView& view, const PixelWindow& window) {
  const float kNone = std::numeric_limits<float>::infinity();
  const int width = window.width(), height = window.height();
  const geometry::Image<float> depth = depth_in_window(view, window, kNone);
  const ColumnNearest columns = nearest_in_columns(depth, kNone);

  const auto nearer = [&](int u, int v) {
    return view.nearer && !view.nearer->data.empty() ? view.nearer->at(u + window.u0, v + window.v0)
                                                     : 0.f;
  };
  cv::Mat outside(height, width, CV_8U);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const bool inside = view.mask.at(u + window.u0, v + window.v0) || nearer(u, v) > 0;
      outside.at<std::uint8_t>(v, u) = inside ? 0 : 255;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(outside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);

  SeenMap map{window, width + 2, {}};
  map.values.assign(static_cast<std::size_t>(width + 2) * (height + 2), 0.f);
  const auto value = [&](int u, int v) {
    const float away = distance.at<float>(v, u);
    if (away > 0) return 0.5f - away;
    if (!view.mask.at(u + window.u0, v + window.v0)) return nearer(u, v);
    const float seen =
        depth.at(u, v) != kNone ? depth.at(u, v) : nearest_depth(columns, width, u, v);
    return seen == kNone ? 0.f : seen;
  };
  // The ring beside the image stays 0.
  const int first_u = window.u0 > 0 ? -1 : 0,
            last_u = window.u1 < view.camera.width ? width : width - 1;
  const int first_v = window.v0 > 0 ? -1 : 0,
            last_v = window.v1 < view.camera.height ? height : height - 1;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      map.values[static_cast<std::size_t>(v + 1) * map.stride + u + 1] = value(u, v);
    }
  }
  for (int v = first_v; v <= last_v; ++v) {
    for (int u = first_u; u <= last_u; ++u) {
      if (u >= 0 && u < width && v >= 0 && v < height) continue;
      map.values[static_cast<std::size_t>(v + 1) * map.stride + u + 1] =
          map.at(std::clamp(u, 0, width - 1) + window.u0, std::clamp(v, 0, height - 1) + window.v0);
    }
  }
  return map;
}

}  // namespace prehend::shape
