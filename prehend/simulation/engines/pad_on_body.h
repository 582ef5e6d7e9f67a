#pragma once

#include "prehend/contact/pad_depths.h"
#include "prehend/contact/pad_kernel.h"
#include "prehend/contact/shape.h"
#include "prehend/contact/texel_law.h"
#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// What pads feel of a body.
contact::Shape felt_shape(const EngineShape& shape);

/// The pad's law with the friction of the two bodies: of theirs the smaller is the static one, the
/// dynamic one keeps the law's ratio.
contact::TexelLaw mounted_law(const EnginePad& pad, const EngineBody& carrier,
                              const EngineBody& touched);

/// A pad of one body and another body that it can feel: what a step needs of both.
struct PadOnBody {
  /// Indices into the scene's pads and bodies.
  PadOnBody(const EngineScene& scene, int pad_index, int body_index);

  /// All pairs of a scene: bodies that collide, carry no pad and are not fixed to the same world.
  static std::vector<PadOnBody> all(const EngineScene& scene);

  struct Place {
    geometry::RigidTransform X_WP;
    Eigen::Vector3d arm_carrier, arm_body;  // m, from the bodies' origins to P's, world
  };
  Place place(const geometry::RigidTransform& X_WCarrier,
              const geometry::RigidTransform& X_WBody) const;

  /// Finds the depths into `state`; false when nothing is within reach.
  bool find_depths(const Place& place, const geometry::RigidTransform& X_WBody, double look_ahead,
                   contact::PadState& state) const;

  int pad, carrier, body;
  geometry::RigidTransform X_CP;  // P on the carrier
  geometry::RigidTransform X_BS;  // the shape on the body
  contact::PadLayout layout;
  contact::PadReach reach;
  contact::Shape shape;
  contact::TexelLaw law;
  contact::PadScratch scratch;
  contact::PadResponse response;
};

/// Bodies with pads touch others by their pads alone.
bool has_pads(const EngineScene& scene, int body);
/// The joint of a body; null: none.
const EngineJoint* joint_of(const EngineScene& scene, int body);

/// Adds what texels of `pad` feel [N] to `forces`, row by row.
void add_pad_forces(const std::vector<PadOnBody>& touches,
                    const std::vector<contact::PadState>& states, int pad,
                    std::vector<double>& forces);

/// The numbers of a pad's state that a step depends on, in a fixed order.
template <class State, class Visit>
void visit_pad_state(State& state, Visit visit) {
  for (auto* values : {&state.bristle_u, &state.bristle_v, &state.normal_force, &state.foam}) {
    for (auto& value : *values) visit(value);
  }
}

}  // namespace prehend::simulation::engines
