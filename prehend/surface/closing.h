#pragma once

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/shape/completed_shape.h"

namespace prehend::surface {

/// `cloud` (with normals) and, on the table, the unseen bottom: the convex outline of the lowest
/// `slice` (fraction of the height over the table) filled with points at `spacing` [m] on the table
/// with normals -table.normal. Where that slice is upright, the gap between it and the table (the
/// lowest points are often lost with the table's) gets points on the outline with outward normals;
/// where it curves under, each of its points goes first to where an arc from it touches the table,
/// which for a ball is right. An object stands on its table, so its bottom is there; without these
/// points the surface bulges below it. No bottom is between the arms of what is not convex, where
/// the cloud is over at least a third of the outline; less, as two sheets without a top, says
/// nothing of what is between.
/// @throws geometry::InputError when the cloud has no normals or does not rise above the table.
geometry::PointCloud close_bottom(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                  double slice, double spacing);

/// Points with outward normals, in W, that close the sides of an object seen straight on: then the
/// seen front and its mirror image are two sheets with nothing between. In each horizontal slice of
/// the height `spacing` [m] the edges of the convex outline that join a seen point with a mirrored
/// one along the symmetry's normal (within 25 deg) are filled where the slice has no point near and
/// the outline stands upright (within 27 deg): under a ball's equator nothing is known of the
/// sides. These edges lie in the bundle of rays through the silhouette, so nothing was seen beyond
/// them.
geometry::PointCloud side_points(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                                 double spacing);

}  // namespace prehend::surface
