#pragma once

#include <vector>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/pad_state.h"
#include "prehend/contact/shape.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::contact {

/// How far a pad can feel: the box of its rays, for the test that leaves it out.
struct PadReach {
  explicit PadReach(const PadLayout& pad);
  Eigen::AlignedBox3d rays_P;  // m, of all rays from their start to the undeformed face
};

/// Which triangles a pad's rays meet, remembered. Embree knows that in single precision only; so it
/// is asked for a pose rounded to kGrid, and the distances are those to the triangles' planes at
/// the pose itself. What is remembered is hence a function of the rounded pose: with and without
/// memory results are bitwise equal, and while nothing moves by kGrid no ray is cast.
struct MeshHits {
  static constexpr double kGrid = 4e-9;  // m; rotations: kGrid over 0.1 m
  Eigen::Matrix<double, 3, 4> rounded_X_PB = Eigen::Matrix<double, 3, 4>::Zero();
  double limit = -1;            // m, of the rays; negative: nothing known
  std::vector<int> triangles;   // as MeshRays::Packet
  std::vector<double> edge_on;  // m, distances where the plane does not tell
};

/// Fills state.depth of all texels for a body at X_PB: thickness less the distance at which the ray
/// that starts `thickness` behind the face meets `shape`; a ray that begins inside has the whole
/// thickness. A shape up to `look_ahead` [m] before the face gives a negative depth, the gap;
/// nothing there gives PadState::kFar. With `gated`, no ray is cast when the shape's bounds cannot
/// be reached; the result is bitwise that without. `hits` (of this pad and shape) remembers the
/// rays on meshes; null: nothing is remembered. Returns false when no ray met anything.
bool find_depths(const PadLayout& pad, const PadReach& reach, const Shape& shape,
                 const geometry::RigidTransform& X_PB, double look_ahead, PadState& state,
                 bool gated = true, MeshHits* hits = nullptr);

}  // namespace prehend::contact
