#pragma once

#include <vector>

#include <Eigen/Core>

namespace prehend::shape {

struct Hollows {
  double depth = 0;     // mean depth of the points within their convex hull, towards the viewer [m]
  double open_top = 0;  // fraction of the points deep within it that look out through its top
};

/// How far the seen points lie within their convex hull: 0 for what bulges towards the viewer. For
/// each point the way along its line of sight to where it leaves the hull; a point counts for
/// `open_top` when that is further than `least_depth` and through a face that looks up.
/// O(points x faces of the hull). @pre points span a volume; `up` is unit.
Hollows hollows(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& viewpoint,
                const Eigen::Vector3d& up, double least_depth);

}  // namespace prehend::shape
