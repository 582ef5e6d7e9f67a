#pragma once

#include "prehend/contact/grasp_stepper.h"

/// A box that lies on one pad: the pad looks up, its face is z = 0.
namespace prehend::contact::testing {

constexpr double kGravity = 9.81;  // m/s^2

struct SlabOptions {
  double mass = 0.3;                     // kg
  Eigen::Vector3d size{0.3, 0.3, 0.02};  // m
  double height = 0;                     // m, of the box's lower face at the start
  double gravity = kGravity;
  TexelLaw law = {};
  PadGrid pad = {};
};

inline GraspModel slab(const SlabOptions& options) {
  GraspModel model;
  model.gravity = {0, 0, -options.gravity};
  model.mass = options.mass;
  model.shape = Shape::box(options.size);
  model.inertia = box_inertia(options.mass, options.size);
  model.X_WB.translation().z() = options.height + 0.5 * options.size.z();
  model.pads.push_back({PadLayout::flat(options.pad), options.law});
  return model;
}

/// Depth of the box's lower face [m].
inline double depth(const GraspStepper& stepper) {
  return stepper.system().model().shape.half_size().z() - stepper.state().p_WB.z();
}

inline StepOptions steps_of(double h, Integration integration = Integration::kFirstOrder) {
  StepOptions options;
  options.step = h;
  options.integration = integration;
  return options;
}

inline TexelLaw elastic_law() {
  TexelLaw law;
  law.static_friction = law.dynamic_friction = 0.8;
  law.bristle_law = BristleLaw::kElastoPlastic;
  law.return_map = true;
  return law;
}

}  // namespace prehend::contact::testing
