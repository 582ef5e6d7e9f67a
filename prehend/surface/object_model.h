#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// What a place of the surface rests on.
enum class SurfaceOrigin : std::uint8_t {
  kSeen = 0,       // a point that was seen is near
  kPredicted = 1,  // only a point that the completion predicts is near
  kAssumed = 2,    // no point is near: the bottom on the table, closed sides, bridged gaps
  kTouched = 3,    // a contact is near
};

/// The confidence in a mesh: that in its completion, and 0.25 at most where `substitute` (of
/// ObjectModel) says that something stands in for it.
inline double mesh_confidence(double completion_confidence, const std::string& substitute) {
  constexpr double kSubstituted = 0.25;
  return substitute.empty() ? completion_confidence : std::min(completion_confidence, kSubstituted);
}

/// Nobody has seen or touched what rests on it.
inline bool is_guessed(SurfaceOrigin origin) {
  return origin == SurfaceOrigin::kPredicted || origin == SurfaceOrigin::kAssumed;
}

/// The predicted solid.
struct ObjectModel {
  geometry::TriangleMesh mesh_W;
  std::vector<SurfaceOrigin> vertex_origin;  // one per vertex of mesh_W
  std::vector<float> vertex_confidence;      // one per vertex: probability that it is there, 0..1
  double guessed_area = 0;                   // part of the area that is_guessed(), 0..1
  geometry::MeshDefects defects;
  std::vector<geometry::TriangleMesh> convex_pieces_W;
  geometry::MassProperties mass_properties;  // in W
  // Mean distance of the seen points (of 4000 of them, spread evenly, if there are more) to the
  // mesh [m].
  double seen_deviation = 0;
  // Why the surface is not that of the completed points, and what stands in for it; "" when it is.
  std::string substitute;
  // Other solids that it may be as well, best first: of CompletedShape::alternatives.
  std::vector<geometry::TriangleMesh> alternatives_W;
  /// How likely mesh_W is the right one, and each of alternatives_W: of all 1. Empty: all alike.
  std::vector<double> shape_weights;
};

}  // namespace prehend::surface
