#include "prehend/perception/virtual_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <Eigen/Dense>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using geometry::PointCloud;
using geometry::RigidTransform;

constexpr double kInlierPixels = 2;
constexpr std::size_t kMinFitPoints = 50;
constexpr int kSmallestImage = 64;     // pixels
constexpr int kLargestImage = 1280;    // pixels
constexpr double kImageMargin = 0.06;  // of the image, around the cloud
constexpr double kMinDepth = 1e-3;     // m

struct Line {
  double slope = 0;      // pixels, a signed focal length
  double intercept = 0;  // pixels
};

// Least squares pixel = slope * ratio + intercept; slope 0 without spread.
Line fit_line(const std::vector<double>& ratios, const std::vector<double>& pixels,
              const std::vector<char>& used) {
  double n = 0;
  double sum_r = 0;
  double sum_p = 0;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (!used[i]) continue;
    n += 1;
    sum_r += ratios[i];
    sum_p += pixels[i];
  }
  if (n < 2) return {};
  double rr = 0;
  double rp = 0;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (!used[i]) continue;
    const double r = ratios[i] - sum_r / n;
    rr += r * r;
    rp += r * (pixels[i] - sum_p / n);
  }
  if (rr < 1e-12 * n) return {};
  const double slope = rp / rr;
  return {slope, sum_p / n - slope * sum_r / n};
}

double residual(const Line& line, double ratio, double pixel) {
  return std::abs(line.slope * ratio + line.intercept - pixel);
}

PointCloud subset(const PointCloud& cloud, std::size_t count) {
  PointCloud result;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / count);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (geometry::is_finite(cloud.points[i])) result.points.push_back(cloud.points[i]);
  }
  return result;
}

// How well a viewpoint explains a surface: share of points that are visible, plus 1 when the
// surface bulges towards the camera (depth grows from the middle of the picture outwards).
double viewpoint_score(const PointCloud& cloud_F, const RigidTransform& X_FC, double spacing) {
  const PointCloud cloud_C = geometry::transformed(cloud_F, X_FC.inverse());
  const auto visible =
      static_cast<double>(visible_points(cloud_C, make_virtual_camera(cloud_C), spacing).size());
  double mean_z = 0;
  double mean_r = 0;
  const Eigen::Vector3d center = geometry::centroid(cloud_C);
  const auto radius = [&center](const Eigen::Vector3f& p) {
    return (p.cast<double>() - center).head<2>().squaredNorm();
  };
  for (const Eigen::Vector3f& p : cloud_C.points) {
    mean_z += static_cast<double>(p.z()) / static_cast<double>(cloud_C.size());
    mean_r += radius(p) / static_cast<double>(cloud_C.size());
  }
  double zz = 0;
  double rr = 0;
  double zr = 0;
  for (const Eigen::Vector3f& p : cloud_C.points) {
    const double z = static_cast<double>(p.z()) - mean_z;
    const double r = radius(p) - mean_r;
    zz += z * z;
    rr += r * r;
    zr += z * r;
  }
  const double bulge = zr / std::max(std::sqrt(zz * rr), 1e-300);
  return visible / static_cast<double>(cloud_C.size()) + bulge;
}

}  // namespace

FittedCamera fit_camera(const PointCloud& cloud) {
  if (!cloud.organized()) {
    throw InputError("The cloud is not organized as an image", "Give its viewpoint");
  }
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> u;
  std::vector<double> v;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    const double z = std::abs(static_cast<double>(p.z()));
    if (!geometry::is_finite(p) || z < kMinDepth) continue;
    x.push_back(static_cast<double>(p.x()) / z);
    y.push_back(static_cast<double>(p.y()) / z);
    u.push_back(static_cast<double>(i % static_cast<std::size_t>(cloud.width)));
    v.push_back(static_cast<double>(i / static_cast<std::size_t>(cloud.width)));
  }
  if (x.size() < kMinFitPoints) {
    throw InputError("The organized cloud has only " + std::to_string(x.size()) +
                         " valid points, too few to find its camera",
                     "Record it again");
  }
  std::vector<char> used(x.size(), 1);
  Line horizontal;
  Line vertical;
  std::size_t inliers = 0;
  for (int round = 0; round < 4; ++round) {
    horizontal = fit_line(x, u, used);
    vertical = fit_line(y, v, used);
    if (horizontal.slope == 0 || vertical.slope == 0) {
      throw InputError(
          "The organized cloud's points lie in one row or column of the image, so its "
          "camera cannot be found",
          "Record a cloud with more extent");
    }
    // The first rounds cut at a multiple of the typical error, the last at the final tolerance.
    std::vector<double> errors(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      errors[i] = std::max(residual(horizontal, x[i], u[i]), residual(vertical, y[i], v[i]));
    }
    std::vector<double> sorted = errors;
    std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
    const double cut = std::max(kInlierPixels, 3 * sorted[sorted.size() / 2]);
    inliers = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      used[i] = errors[i] <= cut;
      inliers += errors[i] <= kInlierPixels;
    }
  }
  FittedCamera fitted;
  fitted.x_flipped = horizontal.slope < 0;
  fitted.y_flipped = vertical.slope < 0;
  fitted.camera = {
      cloud.width,          cloud.height,      std::abs(horizontal.slope), std::abs(vertical.slope),
      horizontal.intercept, vertical.intercept};
  fitted.inlier_share = static_cast<double>(inliers) / static_cast<double>(x.size());
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double du = residual(horizontal, x[i], u[i]);
    const double dv = residual(vertical, y[i], v[i]);
    if (std::max(du, dv) <= kInlierPixels) sum += du * du + dv * dv;
  }
  fitted.rms = std::sqrt(sum / std::max<double>(1, static_cast<double>(inliers)));
  return fitted;
}

double point_spacing(const PointCloud& cloud) {
  const auto points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& p : cloud.points) {
    if (geometry::is_finite(p)) points->emplace_back(p.x(), p.y(), p.z());
  }
  if (points->size() < 2) {
    throw InputError("The cloud has fewer than two valid points", "Record it again");
  }
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(points);
  std::vector<double> distances;
  const std::size_t step = std::max<std::size_t>(1, points->size() / 2000);
  pcl::Indices found(8);
  std::vector<float> squared(8);
  for (std::size_t i = 0; i < points->size(); i += step) {
    const int count = tree.nearestKSearch(static_cast<int>(i), 8, found, squared);
    // The nearest that is not the point itself or a copy of it.
    for (int k = 0; k < count; ++k) {
      if (squared[k] <= 0) continue;
      distances.push_back(std::sqrt(static_cast<double>(squared[k])));
      break;
    }
  }
  if (distances.empty()) {
    throw InputError("All points of the cloud are copies of few", "Record it again");
  }
  std::nth_element(distances.begin(), distances.begin() + distances.size() / 2, distances.end());
  return distances[distances.size() / 2];
}

geometry::PinholeCamera make_virtual_camera(const PointCloud& cloud_C) {
  Eigen::AlignedBox2d ratios;
  std::vector<double> depths;
  for (const Eigen::Vector3f& p : cloud_C.points) {
    if (!geometry::is_finite(p) || static_cast<double>(p.z()) < kMinDepth) continue;
    const double z = static_cast<double>(p.z());
    const Eigen::Vector2d ratio(static_cast<double>(p.x()) / z, static_cast<double>(p.y()) / z);
    if (ratio.cwiseAbs().maxCoeff() > 10) continue;  // beyond 84 degrees
    ratios.extend(ratio);
    depths.push_back(z);
  }
  if (depths.empty()) {
    throw InputError("No point of the cloud is in front of the camera", "Correct the viewpoint");
  }
  std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
  const double pixel = point_spacing(cloud_C) / depths[depths.size() / 2];  // as tangent
  const Eigen::Vector2d size = (ratios.sizes().cwiseMax(4 * pixel) * (1 + 2 * kImageMargin)).eval();
  const double finest = size.maxCoeff() / kLargestImage;
  const double coarsest = size.maxCoeff() / kSmallestImage;
  const double scale = 1 / std::clamp(pixel, finest, coarsest);
  geometry::PinholeCamera camera;
  camera.width = std::max(kSmallestImage, static_cast<int>(std::ceil(size.x() * scale)));
  camera.height = std::max(kSmallestImage, static_cast<int>(std::ceil(size.y() * scale)));
  camera.fx = scale;
  camera.fy = scale;
  camera.cx = 0.5 * (camera.width - 1) - scale * ratios.center().x();
  camera.cy = 0.5 * (camera.height - 1) - scale * ratios.center().y();
  return camera;
}

RigidTransform plausible_viewpoint(const PointCloud& cloud_F, const Eigen::Vector3d& up_F) {
  constexpr int kAzimuths = 24;
  constexpr double kElevation = std::numbers::pi / 6;
  const PointCloud sample = subset(cloud_F, 5000);
  if (sample.empty()) throw InputError("The cloud has no valid points", "Record it again");
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : sample.points) box.extend(p);
  const Eigen::Vector3d center = box.center().cast<double>();
  const double distance = std::clamp(1.5 * static_cast<double>(box.diagonal().norm()), 0.3, 1.5);
  const double spacing = point_spacing(sample);
  const Eigen::Vector3d up = up_F.normalized();
  const Eigen::Vector3d x = up.unitOrthogonal();
  const Eigen::Vector3d y = up.cross(x);
  RigidTransform best = RigidTransform::Identity();
  double best_score = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < kAzimuths; ++k) {
    const double azimuth = 2 * std::numbers::pi * k / kAzimuths;
    const Eigen::Vector3d direction =
        std::cos(kElevation) * (std::cos(azimuth) * x + std::sin(azimuth) * y) +
        std::sin(kElevation) * up;
    const RigidTransform X_FC = geometry::look_at(center + distance * direction, center, up);
    const double score = viewpoint_score(sample, X_FC, spacing);
    if (score > best_score) {
      best_score = score;
      best = X_FC;
    }
  }
  return best;
}

geometry::Image<int> splat(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                           double size) {
  geometry::Image<int> nearest(camera.width, camera.height, -1);
  geometry::Image<float> depth(camera.width, camera.height, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < cloud_C.size(); ++i) {
    const Eigen::Vector3f& p = cloud_C.points[i];
    if (!geometry::is_finite(p) || static_cast<double>(p.z()) < kMinDepth) continue;
    const Eigen::Vector2d pixel = camera.project(p.cast<double>());
    const double half =
        std::clamp(0.5 * (size / static_cast<double>(p.z()) * camera.fx - 1), 0.0, 50.0);
    if (!pixel.allFinite() || pixel.x() < -60 || pixel.y() < -60 || pixel.x() > camera.width + 60 ||
        pixel.y() > camera.height + 60) {
      continue;
    }
    const int u_last = static_cast<int>(std::lround(pixel.x() + half));
    const int v_last = static_cast<int>(std::lround(pixel.y() + half));
    for (int v = static_cast<int>(std::lround(pixel.y() - half)); v <= v_last; ++v) {
      for (int u = static_cast<int>(std::lround(pixel.x() - half)); u <= u_last; ++u) {
        if (!depth.contains(u, v) || depth.at(u, v) <= p.z()) continue;
        depth.at(u, v) = p.z();
        nearest.at(u, v) = static_cast<int>(i);
      }
    }
  }
  return nearest;
}

std::vector<int> visible_points(const PointCloud& cloud_C, const geometry::PinholeCamera& camera,
                                double spacing) {
  const geometry::Image<int> nearest = splat(cloud_C, camera, 2.5 * spacing);
  std::vector<int> visible;
  for (std::size_t i = 0; i < cloud_C.size(); ++i) {
    const Eigen::Vector3f& p = cloud_C.points[i];
    if (!geometry::is_finite(p) || static_cast<double>(p.z()) < kMinDepth) continue;
    const Eigen::Vector2d pixel = camera.project(p.cast<double>());
    if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) continue;
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (!nearest.contains(u, v) || nearest.at(u, v) < 0) continue;
    const double front = static_cast<double>(cloud_C.points[nearest.at(u, v)].z());
    if (static_cast<double>(p.z()) <= front + 6 * spacing) visible.push_back(static_cast<int>(i));
  }
  return visible;
}

}  // namespace prehend::perception
