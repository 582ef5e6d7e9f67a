#include "tests/oracles/reference_vote.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "prehend/shape/seen_map.h"

namespace prehend::shape {
namespace {

double ramp(double x) { return std::clamp(x - 0.5, 0.0, 1.0); }

/// For each pixel the nearest one of `sources` [pixels, squared] and the least of their `values`
/// that are equally near. First along columns, then along rows.
struct Nearest {
  geometry::Image<double> squared;
  geometry::Image<double> value;
};

Nearest nearest(const geometry::Image<bool>& sources, const geometry::Image<double>& values) {
  const double kNone = std::numeric_limits<double>::infinity();
  const int width = sources.width, height = sources.height;
  Nearest column{geometry::Image<double>(width, height, kNone),
                 geometry::Image<double>(width, height, 0)};
  const auto take = [](double squared, double value, double& best, double& best_value) {
    if (squared < best || (squared == best && value < best_value)) {
      best = squared;
      best_value = value;
    }
  };
  for (int u = 0; u < width; ++u) {
    for (int v = 0; v < height; ++v) {
      for (int w = 0; w < height; ++w) {
        if (!sources.data[static_cast<std::size_t>(w) * width + u]) continue;
        take((v - w) * (v - w), values.at(u, w), column.squared.at(u, v), column.value.at(u, v));
      }
    }
  }
  Nearest result = column;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (int w = 0; w < width; ++w) {
        take((u - w) * (u - w) + column.squared.at(w, v), column.value.at(w, v),
             result.squared.at(u, v), result.value.at(u, v));
      }
    }
  }
  return result;
}

}  // namespace

SeenImages reference_images(const ObjectView& view) {
  check_view(view);
  const auto& camera = view.camera;
  geometry::Image<bool> inside(camera.width, camera.height, false);
  geometry::Image<bool> has_point(camera.width, camera.height, false);
  geometry::Image<double> depth(camera.width, camera.height, 0);
  const bool hidden = view.nearer && !view.nearer->data.empty();
  for (std::size_t i = 0; i < inside.data.size(); ++i) {
    inside.data[i] = view.mask.data[i] != 0 || (hidden && view.nearer->data[i] > 0);
  }
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    const Eigen::Vector2d pixel = camera.project(p_C);
    const double u = std::floor(pixel.x() + 0.5), v = std::floor(pixel.y() + 0.5);
    if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) continue;
    const std::size_t i = static_cast<std::size_t>(v) * camera.width + static_cast<std::size_t>(u);
    depth.data[i] = has_point.data[i] ? std::min(depth.data[i], p_C.z()) : p_C.z();
    has_point.data[i] = true;
  }
  SeenImages images{nearest(inside, depth).squared, nearest(has_point, depth).value};
  for (double& squared : images.distance.data) squared = std::sqrt(squared);
  for (std::size_t i = 0; hidden && i < inside.data.size(); ++i) {
    if (view.mask.data[i] == 0 && view.nearer->data[i] > 0) {
      images.depth.data[i] = static_cast<double>(view.nearer->data[i]);
    }
  }
  return images;
}

VoteTally reference_tally(const ObjectView& view, const SeenImages& images,
                          const geometry::Plane& plane_C, const VoteOptions& options) {
  const auto& camera = view.camera;
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  const double focal_length = 0.5 * (camera.fx + camera.fy);
  const double t = options.depth_tolerance;
  VoteTally tally;
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    const double motion = -2 * plane_C.signed_distance(p_C);
    const Eigen::Vector3d mirrored_C = p_C + motion * plane_C.normal;
    ++tally.points;
    const Eigen::Vector2d pixel = camera.project(mirrored_C);
    const double u = std::floor(pixel.x() + 0.5), v = std::floor(pixel.y() + 0.5);
    if (!(mirrored_C.z() > 0 && u >= 0 && v >= 0 && u < camera.width && v < camera.height)) {
      ++tally.unseen;
      continue;
    }
    const double distance = images.distance.at(static_cast<int>(u), static_cast<int>(v));
    if (distance > 0) {
      const double outside = (distance - 0.5) * mirrored_C.z() / focal_length;
      ++tally.outside_points;
      tally.outside_pixels += distance * distance;
      tally.outside_squared += outside * outside;
      tally.contradicted += ramp(outside / (0.5 * t));
    } else {
      const double before =
          images.depth.at(static_cast<int>(u), static_cast<int>(v)) - mirrored_C.z();
      if (before > kNearer) {
        ++tally.nearer_points;
        tally.nearer += before;
      }
      tally.in_front += std::max(0.0, before - t);
      tally.contradicted += ramp(before / t);
      tally.hidden += before < -t;
      if (std::abs(motion) > options.least_motion) {
        tally.coincident += std::max(0.0, 1 - std::abs(before) / t);
      }
    }
  }
  return tally;
}

StartingPlane reference_start(const ObjectView& view) {
  const geometry::Plane& table = view.table_W;
  StartingPlane start;
  start.center_W.setZero();
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    start.center_W += table.project(p_W.cast<double>());
  }
  start.center_W /= static_cast<double>(view.cloud_W.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    const Eigen::Vector3d r = table.project(p_W.cast<double>()) - start.center_W;
    covariance += r * r.transpose();
  }
  // Ascending eigenvalues: the first is the table's normal.
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  const Eigen::Vector3d major = axes.col(2), minor = axes.col(1);
  const Eigen::Vector3d view_direction = start.center_W - table.project(view.X_WC.translation());
  const bool along_major =
      std::abs(major.dot(view_direction)) <= std::abs(minor.dot(view_direction));
  start.normal_W = (along_major ? major : minor).cross(table.normal).normalized();
  if (start.normal_W.dot(view_direction) < 0) start.normal_W = -start.normal_W;
  return start;
}

std::vector<geometry::Plane> reference_hypotheses(const ObjectView& view, int orientations,
                                                  int shifts, double max_angle) {
  const StartingPlane start = reference_start(view);
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  std::vector<geometry::Plane> planes_C;
  for (int j = 0; j < orientations; ++j) {
    const double angle = orientations == 1 ? 0 : max_angle * (2.0 * j / (orientations - 1) - 1);
    const Eigen::Vector3d normal_W = Eigen::AngleAxisd(angle, view.table_W.normal) * start.normal_W;
    double farthest = 0;
    for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
      farthest = std::max(farthest, normal_W.dot(p_W.cast<double>() - start.center_W));
    }
    for (int i = 0; i < shifts; ++i) {
      const double shift = farthest * i / (2.0 * shifts);
      const Eigen::Vector3d normal_C = X_CW.linear() * normal_W;
      planes_C.push_back(
          {normal_C, normal_C.dot(X_CW * Eigen::Vector3d(start.center_W + shift * normal_W))});
    }
  }
  return planes_C;
}

std::vector<VoteTally> reference_votes(const ObjectView& view,
                                       const std::vector<geometry::Plane>& planes_C,
                                       const VoteOptions& options) {
  std::vector<VoteTally> tallies;
  for (const geometry::Plane& plane_C : planes_C) {
    tallies.push_back(reference_tally(view, reference_images(view), plane_C, options));
  }
  return tallies;
}

}  // namespace prehend::shape
