#pragma once

#include "prehend/geometry/plane.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/convex_pieces.h"
#include "prehend/surface/object_model.h"
#include "prehend/surface/reconstruct.h"
#include "prehend/surface/shape_cloud.h"

namespace prehend::surface {

/// Half a diagonal of a texel of the tactile pads that hands carry (3.4 mm, Weiss DSA 9205) [m]:
/// finer detail of a surface nobody feels, and what one view shows of it is mostly noise.
inline constexpr double kFinestDetail = 0.0024;

struct ModelOptions {
  /// Nodes of fast_poisson are no nearer to each other than `finest_detail` [m], >= 0, points of
  /// which the surface is made no nearer either; 0: as near as `resolution` and `spacing`
  /// say. Changes nothing of large bodies, whose 128 nodes are farther apart.
  explicit ModelOptions(double finest_detail);
  ModelOptions() : ModelOptions(kFinestDetail) {}

  OrientedCloudOptions cloud;
  bool close_sides = true;              // see shape_cloud.h
  bool hollow_vessels = true;           // the same
  bool keep_out_of_empty_space = true;  // see empty_space.h
  SurfaceOptions surface;
  ConvexPiecesOptions convex_pieces;

  ShapeCloudOptions points() const { return {cloud, close_sides, hollow_vessels}; }
};

/// Seconds each step took, in one thread.
struct ModelTimes {
  double normals = 0;  // voxels, outlier filter, normals
  double poisson = 0;  // with the watertight check
  double convex_pieces = 0;
  double properties = 0;  // mass properties and deviation
  double alternatives = 0;
};

/// The watertight mesh of a completed shape that stands on `table_W` (normal towards the object):
/// shape_cloud(), reconstruct().
/// `normals_seconds` is filled when given. @throws geometry::InputError when the shape has too few
/// points or gives no such mesh.
geometry::TriangleMesh mesh_of(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                               const ModelOptions& options = {}, double* normals_seconds = nullptr);

/// The predicted solid of a completed shape that stands on `table_W` (normal towards the object):
/// mesh_of(), convex_pieces(), mass properties, what the vertices rest on, the mean distance of the
/// seen points to the mesh, and the meshes of the shape's alternatives (those that give one). Where
/// the completed points give no watertight mesh, the first alternative that does stands in for
/// them, else the convex hull of what was seen and of its foot on the table: ObjectModel.substitute
/// says so. `times` is filled when given. @throws geometry::InputError for fewer than four points,
/// and for points without volume over the table, with what to do about it.
ObjectModel make_object_model(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                              const ModelOptions& options = {}, ModelTimes* times = nullptr);

/// The same of a surface that was made of the shape elsewhere: without alternatives.
/// @throws std::invalid_argument for a shape without points.
ObjectModel model_of_shape(geometry::TriangleMesh mesh_W, const shape::CompletedShape& shape,
                           const ConvexPiecesOptions& options = {}, ModelTimes* times = nullptr);

/// The solid of a mesh that is known, not predicted: convex pieces and mass properties, those of
/// its convex hull where it is not closed (`defects` says so); nothing of its surface is guessed.
/// @throws geometry::InputError for a mesh without volume.
ObjectModel model_of_mesh(geometry::TriangleMesh mesh_W, const ConvexPiecesOptions& options = {});

/// Everything of `model` where the frame it was in has the pose X_WO.
ObjectModel moved(const ObjectModel& model_O, const geometry::RigidTransform& X_WO);

}  // namespace prehend::surface
