#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"

// How perception divides clouds: voxels, clusters and a plane's outline.
namespace prehend::perception {

/// A voxel grid over points: the mean of each occupied voxel and who fell into which.
struct VoxelGrid {
  std::vector<Eigen::Vector3f> centroids;  // v
  std::vector<std::vector<int>> members;   // v, indices into the points, ascending
};

/// Puts the points named by `indices` (finite, within 1000 km / leaf) into voxels of side
/// `leaf_size` [m]; 0 gives each point its own voxel. Order: by voxel coordinate z, y, x.
VoxelGrid make_voxel_grid(const std::vector<Eigen::Vector3f>& points,
                          const std::vector<int>& indices, double leaf_size);

/// Its centroids alone.
std::vector<Eigen::Vector3f> voxel_centroids(const std::vector<Eigen::Vector3f>& points,
                                             const std::vector<int>& indices, double leaf_size);

/// PCL reports by printing; perception reports by exceptions. Called before PCL is.
void silence_pcl();

/// Groups of points connected by gaps up to `tolerance` [m] with at least `min_size` members, by
/// PCL's Euclidean cluster extraction. Indices ascending; largest group first, ties by first index.
std::vector<std::vector<int>> euclidean_clusters(const std::vector<Eigen::Vector3f>& points,
                                                 double tolerance, int min_size);

/// Convex outline of a plane's points in the plane's own axes (PCL/Qhull).
class PlaneOutline {
 public:
  /// @throws geometry::InputError for fewer than three points or for collinear ones.
  PlaneOutline(const geometry::Plane& plane, const std::vector<Eigen::Vector3f>& points);

  /// Whether `p`, projected onto the plane, is inside or at most `margin` [m] outside an edge.
  bool contains(const Eigen::Vector3d& p, double margin) const;

  std::vector<Eigen::Vector3d> vertices() const;  // counter-clockwise about the normal
  double area() const;                            // m^2

 private:
  struct Side {
    Eigen::Vector2d corner, edge;  // m, the edge from that corner to the next
    double length = 0;             // m
  };

  Eigen::Vector2d flat(const Eigen::Vector3d& p) const;

  geometry::Plane plane_;
  Eigen::Vector3d x_;  // axes in the plane
  Eigen::Vector3d y_;
  std::vector<Eigen::Vector2d> corners_;  // counter-clockwise
  std::vector<Side> sides_;
  Eigen::Vector2d center_ = Eigen::Vector2d::Zero();  // of the corners
  double inner_ = 0;  // m: what is nearer to the centre is inside, and most points are
};

}  // namespace prehend::perception
