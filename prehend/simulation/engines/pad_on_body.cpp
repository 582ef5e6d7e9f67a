#include "prehend/simulation/engines/pad_on_body.h"

#include <algorithm>

namespace prehend::simulation::engines {

contact::Shape felt_shape(const EngineShape& shape) {
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      return contact::Shape::box(shape.size);
    case EngineShape::Kind::kSphere:
      return contact::Shape::sphere(shape.radius);
    case EngineShape::Kind::kCylinder:
      return contact::Shape::cylinder(shape.radius, shape.length);
    case EngineShape::Kind::kCapsule:
      return contact::Shape::capsule(shape.radius, shape.length);
    case EngineShape::Kind::kConvexPieces:
      return contact::Shape::mesh(geometry::concatenated(*shape.pieces));
  }
  throw std::logic_error("an EngineShape of no kind");
}

contact::TexelLaw mounted_law(const EnginePad& pad, const EngineBody& carrier,
                              const EngineBody& touched) {
  contact::TexelLaw law = pad.law;
  const double friction = std::min(carrier.friction, touched.friction);
  const double ratio = law.static_friction > 0 ? law.dynamic_friction / law.static_friction : 1.0;
  law.static_friction = friction;
  law.dynamic_friction = ratio * friction;
  return law;
}

PadOnBody::PadOnBody(const EngineScene& scene, int pad_index, int body_index)
    : pad(pad_index),
      carrier(scene.pads[pad_index].body),
      body(body_index),
      X_CP(scene.pads[pad_index].X_BP),
      X_BS(scene.bodies[body_index].X_BS),
      layout(scene.pads[pad_index].layout),
      reach(layout),
      shape(scene.bodies[body_index].felt ? *scene.bodies[body_index].felt
                                          : felt_shape(scene.bodies[body_index].shape)),
      law(mounted_law(scene.pads[pad_index], scene.bodies[carrier], scene.bodies[body_index])),
      scratch(layout) {}

std::vector<PadOnBody> PadOnBody::all(const EngineScene& scene) {
  std::vector<PadOnBody> touches;
  for (int p = 0; p < static_cast<int>(scene.pads.size()); ++p) {
    for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) {
      const bool moves = !scene.bodies[b].is_fixed || !scene.bodies[scene.pads[p].body].is_fixed;
      if (has_pads(scene, b) || !scene.bodies[b].collides || !moves) continue;
      touches.emplace_back(scene, p, b);
    }
  }
  return touches;
}

PadOnBody::Place PadOnBody::place(const geometry::RigidTransform& X_WCarrier,
                                  const geometry::RigidTransform& X_WBody) const {
  const geometry::RigidTransform X_WP = X_WCarrier * X_CP;
  return {X_WP, X_WP.translation() - X_WCarrier.translation(),
          X_WP.translation() - X_WBody.translation()};
}

bool PadOnBody::find_depths(const Place& place, const geometry::RigidTransform& X_WBody,
                            double look_ahead, contact::PadState& state) const {
  return contact::find_depths(layout, reach, shape,
                              place.X_WP.inverse(Eigen::Isometry) * X_WBody * X_BS, look_ahead,
                              state);
}

bool has_pads(const EngineScene& scene, int body) {
  return std::any_of(scene.pads.begin(), scene.pads.end(),
                     [&](const EnginePad& pad) { return pad.body == body; });
}

const EngineJoint* joint_of(const EngineScene& scene, int body) {
  for (const EngineJoint& joint : scene.joints) {
    if (joint.body == body) return &joint;
  }
  return nullptr;
}

void add_pad_forces(const std::vector<PadOnBody>& touches,
                    const std::vector<contact::PadState>& states, int pad,
                    std::vector<double>& forces) {
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k].pad != pad) continue;
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] += states[k].normal_force[i];
  }
}

}  // namespace prehend::simulation::engines
