#pragma once

#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/normals.h"
#include "prehend/surface/object_model.h"

namespace prehend::surface {

struct ShapeCloudOptions {
  OrientedCloudOptions cloud;
  bool close_sides = true;     // see closing.h
  bool hollow_vessels = true;  // see vessel.h: their sides are not closed, they have walls
};

/// What the surface of a completed shape is made of.
struct ShapeCloud {
  geometry::PointCloud cloud_W;  // with normals
  /// One per point: kSeen; kPredicted, of a mirrored point or one of a fall-back; kAssumed, a
  /// closed side or a wall of a vessel.
  std::vector<SurfaceOrigin> basis;
  /// One per point: which of the shape's points it is made of; of assumed ones kMirrored.
  std::vector<shape::PointOrigin> origin;
};

/// The points that reconstruct() takes: oriented_cloud() with the walls of a vessel or closed sides
/// where asked for, of a shape that stands on `table_W` (normal towards the object).
/// @throws geometry::InputError for a shape with too few or non-finite points.
ShapeCloud shape_cloud(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                       const ShapeCloudOptions& options = {});

/// Between the points of a closing, and what a point stands for: 1/90 of the cloud's longest side
/// [m].
double spacing_of(const geometry::PointCloud& cloud);

}  // namespace prehend::surface
