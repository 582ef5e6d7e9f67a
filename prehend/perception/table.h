#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

struct TableOptions {
  double inlier_distance = 0.010;  // m at 1 m depth, > 0; grows with depth squared beyond 1 m
  int max_iterations = 1000;       // RANSAC draws per plane, > 0
  int max_planes = 6;              // candidate planes that are looked at, > 0
  double min_support = 0.04;       // 0..1, share of the finite points a plane must have
  double min_extent = 0.08;        // m, shorter side of the plane's inliers
  /// Largest angle between the plane's normal and up [rad]. Only with a known up direction.
  double max_tilt = 0.6;
  double leaf_size = 0.008;   // m, the search runs on a voxel grid; 0 uses every point
  double max_distance = 3.0;  // m, farther points are not looked at
  /// Things that stand on a table, by which it is told from walls and floors: bottoms within
  /// contact_height, tops between min and max_object_height, extent up to max_object_extent.
  double contact_height = 0.05;     // m
  double min_object_height = 0.02;  // m
  double max_object_height = 0.45;  // m
  double max_object_extent = 0.60;  // m
  std::uint64_t seed = 1;
};

/// A table found in a view.
struct Table {
  geometry::Plane plane_C;              // optical frame; normal towards the camera and the objects
  std::vector<int> inliers;             // of the cloud that was searched, ascending
  std::vector<Eigen::Vector3d> hull_C;  // convex outline of the inliers, on the plane, in order
  double rms = 0;                       // m, of the inliers' distances to the plane
  int object_points = 0;                // voxels of things that stand on it
};

/// Finds the plane that carries the objects. Candidates come from RANSAC (PCL, fixed seed) one
/// after the other, each refined by least squares over its inliers. The camera is above a table, so
/// normals point to the camera. Of the candidates the one with the highest score wins: its support
/// times a factor for its tilt (the angle to `up_C`; unknown: to the camera's own up, -y, a soft
/// preference that a wall or the front of a box fails and a view from above passes) times a factor
/// for what stands on it.
/// Deterministic for the same cloud, options and seed.
/// @throws std::invalid_argument for a bad option, geometry::InputError with the reason when the
/// cloud is empty, has too few finite points, is one point, a line, or has no plausible table.
Table find_table(const geometry::PointCloud& cloud_C, const TableOptions& options = {},
                 const std::optional<Eigen::Vector3d>& up_C = std::nullopt);

/// As find_table, but every plane that may carry objects (a table, a shelf's boards, a box's lid),
/// best first; find_table's answer is the first. At least one. @throws as find_table.
std::vector<Table> find_tables(const geometry::PointCloud& cloud_C,
                               const TableOptions& options = {},
                               const std::optional<Eigen::Vector3d>& up_C = std::nullopt);

/// The table that lies in a plane that is known: its inliers, and the outline of all points that
/// are on it or over it. @throws geometry::InputError when no point is.
Table table_of_plane(const geometry::PointCloud& cloud_C, const geometry::Plane& plane_C,
                     const TableOptions& options = {});

}  // namespace prehend::perception
