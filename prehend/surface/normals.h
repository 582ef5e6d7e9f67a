#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/point_cloud.h"
#include "prehend/shape/completed_shape.h"

namespace prehend::surface {

/// Statistical outlier filter: a point goes when the mean distance to its `neighbors` nearest ones
/// exceeds the cloud's average of that by more than `deviations` standard deviations.
struct OutlierOptions {
  int neighbors = 12;     // >= 1
  double deviations = 3;  // > 0
};

/// Indices of the points of `points` [m] that are kept, ascending (Rusu et al., "Towards 3D point
/// cloud based object maps for household environments", 2008). All when there are no more points
/// than neighbours. O(n log n). @pre points are finite.
std::vector<int> without_outliers(const std::vector<Eigen::Vector3f>& points,
                                  const OutlierOptions& options = {});

/// Normals by the plane that fits a point and its nearest neighbours best.
struct NormalOptions {
  int neighbors = 16;  // without the point itself, >= 3
};

/// One unit normal per point of `points` [m], turned so that it points towards `viewpoints[i]`:
/// n · (viewpoint - p) >= 0. The plane is the eigenvector of the smallest eigenvalue of the
/// neighbourhood's covariance (Hoppe et al., "Surface reconstruction from unorganized points",
/// SIGGRAPH 1992); neighbours by FLANN's single kd-tree, exact. O(n log n).
/// @throws geometry::InputError when there are not more points than neighbours, or one is not
/// finite. @pre as many viewpoints as points.
std::vector<Eigen::Vector3f> estimate_normals(const std::vector<Eigen::Vector3f>& points,
                                              const std::vector<Eigen::Vector3d>& viewpoints,
                                              const NormalOptions& options = {});

/// From a completed shape to points with normals, all in W.
struct OrientedCloudOptions {
  /// Points are averaged in voxels of this side [m]; 0: 1/90 of the longest extent. >= 0.
  double spacing = 0;
  double least_spacing = 0;  // m, >= 0: where `spacing` is 0 the side is not shorter
  OutlierOptions outliers;
  NormalOptions normals;
  /// Neighbours are of the same origin only. The two sides of a thin wall are of different ones, as
  /// near to each other as neighbours are.
  bool separate_origins = false;
  /// Voxels' means are moved onto quadratic surfaces fitted about them: what a sensor's noise makes
  /// of a face is neither its normal nor where two fingers touch it.
  bool smooth = true;
};

/// The points of `shape`, averaged in voxels and smoothed (each origin by itself), without
/// outliers, with normals towards the viewpoint of their origin: mirrored points towards the
/// mirrored viewpoint, those that a fall-back made to the side that it says is outside.
/// @param origins if given, is filled with one per point: those of the shape that it is made of.
/// @throws geometry::InputError for a shape with too few or non-finite points.
geometry::PointCloud oriented_cloud(const shape::CompletedShape& shape,
                                    const OrientedCloudOptions& options = {},
                                    std::vector<shape::PointOrigin>* origins = nullptr);

}  // namespace prehend::surface
