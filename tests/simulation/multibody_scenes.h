#pragma once

#include <cmath>
#include <memory>

#include "prehend/simulation/engines/multibody_engine.h"

namespace prehend::simulation::engines {

inline EngineBody body_of(EngineShape::Kind kind, double mass, const Eigen::Vector3d& p) {
  EngineBody body;
  body.name = "body";
  body.shape.kind = kind;
  body.mass = mass;
  body.X_WB.translation() = p;
  return body;
}

inline EngineBody box(double mass, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
  EngineBody body = body_of(EngineShape::Kind::kBox, mass, p);
  body.shape.size = size;
  return body;
}

inline EngineJoint hinge(int parent, int body, const Eigen::Vector3d& anchor,
                         const Eigen::Vector3d& axis = Eigen::Vector3d::UnitY()) {
  EngineJoint joint;
  joint.kind = EngineJoint::Kind::kRevolute;
  joint.parent = parent;
  joint.body = body;
  joint.axis_W = axis;
  joint.anchor_W = anchor;
  return joint;
}

inline std::unique_ptr<MultibodyEngine> loaded(const EngineScene& scene) {
  validate(scene);
  auto engine = std::make_unique<MultibodyEngine>();
  engine->load(scene);
  return engine;
}

inline void run(Engine& engine, const EngineScene& scene, double seconds) {
  const auto steps = std::lround(seconds / scene.step);
  for (long i = 0; i < steps; ++i) engine.step();
}

}  // namespace prehend::simulation::engines
