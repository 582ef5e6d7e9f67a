#include "prehend/belief/percept_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "prehend/belief/held_object.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/surface_samples.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::DepthImage;
using geometry::PinholeCamera;

constexpr int kMostColumns = 320;     // of the picture that is compared
constexpr int kLeastPixels = 15;      // of it, that show something
constexpr int kThoughtPoints = 400;   // of what is thought to be held
constexpr double kRoom = 0.6;         // of its radius, round it, and ...
constexpr double kLeastRoom = 0.025;  // ... m, at least
// m, from the robot's links: what matching makes of their outlines is wider than they are, and
// there are few points to outweigh it.
constexpr double kClearance = 0.01;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// The ball in which it may be.
struct Ball {
  Vector3d middle_C = Vector3d::Zero();
  double radius = 0;  // m, of what is thought to be held
  double room = 0;    // m, round its surface
};

Ball ball_of(const LiftedView& view) {
  if (view.thought_W.empty()) throw std::invalid_argument("LiftedView: thought_W has no point");
  Ball ball;
  const Vector3d middle_W = geometry::centroid(view.thought_W);
  for (const Eigen::Vector3f& p : view.thought_W.points) {
    ball.radius = std::max(ball.radius, (p.cast<double>() - middle_W).norm());
  }
  ball.room = std::max(kLeastRoom, kRoom * ball.radius);
  ball.middle_C = view.X_WC.inverse(Eigen::Isometry) * middle_W;
  return ball;
}

HeldLookOptions options_of(const Ball& ball, int step) {
  HeldLookOptions options;
  options.room = ball.room / std::max(ball.radius, 1e-6);
  options.edge = (options.edge + step - 1) / step;
  options.clearance = kClearance;
  return options;
}

/// Of every `step`th pixel.
PinholeCamera coarser(PinholeCamera camera, int step) {
  camera.width = (camera.width + step - 1) / step;
  camera.height = (camera.height + step - 1) / step;
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value /= step;
  return camera;
}

DepthImage coarser(const DepthImage& depth, const PinholeCamera& camera, int step) {
  DepthImage few(camera.width, camera.height, kUnknown);
  for (int v = 0; v < few.height; ++v) {
    for (int u = 0; u < few.width; ++u) few.at(u, v) = depth.at(step * u, step * v);
  }
  return few;
}

/// Pixels [first, last) of a row and a column that may show the ball, within the picture.
struct Window {
  int left = 0, right = 0, top = 0, bottom = 0;
};

Window window_of(const PinholeCamera& camera, const Ball& ball, int margin) {
  const double reach = ball.radius + ball.room, nearest = ball.middle_C.z() - reach;
  if (!(nearest > 0)) return {0, camera.width, 0, camera.height};  // all round the camera
  const Eigen::Vector2d middle = camera.project(ball.middle_C);
  // A ball's outline reaches further than its middle's depth says.
  const double x = camera.fx * reach / nearest + margin, y = camera.fy * reach / nearest + margin;
  const auto within = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  return {within(std::floor(middle.x() - x), camera.width),
          within(std::ceil(middle.x() + x) + 1, camera.width),
          within(std::floor(middle.y() - y), camera.height),
          within(std::ceil(middle.y() + y) + 1, camera.height)};
}

int step_of(const PinholeCamera& camera) {
  if (camera.width <= 0 || camera.height <= 0) {
    throw std::invalid_argument("LiftedView: the camera has no pixels");
  }
  return (camera.width + kMostColumns - 1) / kMostColumns;
}

PerceivedView view_of(const DepthImage& depth, const PinholeCamera& camera, const LiftedView& view,
                      const Ball& ball, const HeldLookOptions& options) {
  const geometry::MaskImage mask =
      held_pixels(depth, camera, view.X_WC, view.table_W, view.robot_W, view.thought_W, options);
  const Window window = window_of(camera, ball, options.edge);
  PerceivedView seen;
  seen.depth = DepthImage(std::max(0, window.right - window.left),
                          std::max(0, window.bottom - window.top), kUnknown);
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  int count = 0;
  for (int v = window.top; v < window.bottom; ++v) {
    for (int u = window.left; u < window.right; ++u) {
      if (mask.at(u, v) == 0) continue;
      const float z = depth.at(u, v);
      seen.depth.at(u - window.left, v - window.top) = z;
      const Vector3d p_C = camera.unproject(u, v, static_cast<double>(z)) - ball.middle_C;
      sum += p_C;
      squares += p_C.cwiseAbs2();
      seen.area += static_cast<double>(z) * static_cast<double>(z) / (camera.fx * camera.fy);
      ++count;
    }
  }
  if (count < kLeastPixels) {
    seen.area = 0;
    return seen;
  }
  const Vector3d mean = sum / count;
  const Vector3d origin_C = view.X_WC.inverse(Eigen::Isometry) * view.X_WH.translation();
  seen.center_C = ball.middle_C + mean - origin_C;
  seen.spread = (squares / count - mean.cwiseAbs2()).cwiseMax(0).cwiseSqrt().head<2>();
  return seen;
}

}  // namespace

geometry::PointCloud thought_surface(const geometry::TriangleMesh& mesh) {
  geometry::PointCloud cloud;
  for (const geometry::SurfaceSample& sample : geometry::surface_samples(mesh, kThoughtPoints, 1)) {
    cloud.points.push_back(sample.point.cast<float>());
  }
  return cloud;
}

PerceivedView perceived_view(const DepthImage& depth, const LiftedView& view) {
  if (depth.width != view.camera.width || depth.height != view.camera.height) {
    throw std::invalid_argument("perceived_view(): the depth is not of the camera's size");
  }
  const int step = step_of(view.camera);
  const PinholeCamera camera = coarser(view.camera, step);
  const Ball ball = ball_of(view);
  return view_of(coarser(depth, camera, step), camera, view, ball, options_of(ball, step));
}

PerceivedView predicted_view(const geometry::TriangleMesh& object_W, const LiftedView& view) {
  const int step = step_of(view.camera);
  const PinholeCamera camera = coarser(view.camera, step);
  const Ball ball = ball_of(view);
  const HeldLookOptions options = options_of(ball, step);
  const geometry::MeshQuery object(object_W);
  std::optional<geometry::MeshQuery> robot;
  if (geometry::TriangleMesh links = geometry::concatenated(view.robot_W);
      !links.triangles.empty()) {
    robot.emplace(std::move(links));
  }
  const Vector3d eye_W = view.X_WC.translation();
  const double eye_height = view.table_W.signed_distance(eye_W);
  DepthImage depth(camera.width, camera.height, kUnknown);
  const Window window = window_of(camera, ball, 2 * options.edge);
  for (int v = window.top; v < window.bottom; ++v) {
    for (int u = window.left; u < window.right; ++u) {
      const Vector3d ray_C = camera.unproject(u, v, 1);
      const double length = ray_C.norm();  // of a ray at depth 1 m
      const Vector3d ray_W = view.X_WC.linear() * ray_C / length;
      double nearest = std::numeric_limits<double>::infinity();  // m, along the ray
      const double down = -view.table_W.normal.dot(ray_W);
      if (down > 0 && eye_height > 0) nearest = eye_height / down;
      if (const auto hit = object.cast_ray(eye_W, ray_W))
        nearest = std::min(nearest, hit->distance);
      if (const auto hit = robot ? robot->cast_ray(eye_W, ray_W) : std::nullopt) {
        nearest = std::min(nearest, hit->distance);
      }
      if (std::isfinite(nearest)) depth.at(u, v) = static_cast<float>(nearest / length);
    }
  }
  return view_of(depth, camera, view, ball, options);
}

}  // namespace prehend::belief
