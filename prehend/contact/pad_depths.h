#pragma once

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

/// Fills state.depth of all texels for a body at X_PB: thickness less the distance at which the ray
/// that starts `thickness` behind the face meets `shape`; a ray that begins inside has the whole
/// thickness. A shape up to `look_ahead` [m] before the face gives a negative depth, the gap;
/// nothing there gives PadState::kFar. With `gated`, no ray is cast when the shape's bounds cannot
/// be reached; the result is bitwise that without. Returns false when no ray met anything.
bool find_depths(const PadLayout& pad, const PadReach& reach, const Shape& shape,
                 const geometry::RigidTransform& X_PB, double look_ahead, PadState& state,
                 bool gated = true);

}  // namespace prehend::contact
