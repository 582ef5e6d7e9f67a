#pragma once

#include <string>
#include <vector>

#include "prehend/robot/formats/robot_description.h"
#include "prehend/robot/formats/shape_mesh.h"

namespace prehend::robot::formats {

/// Two links whose collision shapes are in one another.
struct LinkOverlap {
  std::string first, second;
  /// How far they have to go apart [m], along the best of the normals of the faces of their convex
  /// hulls: of two boxes beside one another exact, of hollow shapes too much. Whether they overlap
  /// at all is told by the meshes themselves.
  double depth = 0;
};

/// Links that overlap by more than `least` [m] with joints at rest: at 0, or the limit nearest to
/// it. Left out are parent and child, also with fixed joints between them, links that a loop holds
/// together, pairs of `disabled_collisions`, and shapes that are not read or have no volume. Of
/// links with many shapes the deepest overlap counts. Cost: boxes around the shapes are swept
/// first; meshes are compared only where their hulls overlap. Some milliseconds of a hand of
/// 100,000 triangles. Bounds: hulls have at most 500 vertices, those of rounder ones are the
/// outermost of 480 directions, 0.4 % within; meshes of more than 200,000 triangles are thinned: by
/// 1/100 of their extent, rough ones by more; where very many shapes are near one another, the
/// first pairs are looked at. @param remarks says of the last two. @throws as link_poses()
std::vector<LinkOverlap> overlaps_at_rest(const RobotDescription& robot, ShapeMeshes& meshes,
                                          double least = 1e-3,
                                          std::vector<std::string>* remarks = nullptr);

}  // namespace prehend::robot::formats
