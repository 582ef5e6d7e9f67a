#pragma once

#include <cmath>
#include <memory>

#include <Eigen/LU>

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

/// A cube of 50 g between two jaws of 50 g on slides (joints 0 and 1, positive forces close) that
/// touch it with pads or as plates.
inline EngineScene pressed_cube(bool pads) {
  EngineScene scene;
  scene.bodies = {box(0.05, {0.05, 0.05, 0.05}, {0, 0, 0})};
  for (const int side : {1, -1}) {
    scene.bodies.push_back(box(0.05, {0.024, 0.012, 0.05}, {0, side * (0.031 - 1e-6), 0}));
    EngineJoint slide;
    slide.body = side > 0 ? 1 : 2;
    slide.axis_W = Eigen::Vector3d(0, -side, 0);
    scene.joints.push_back(slide);
    if (!pads) continue;
    EnginePad pad;
    pad.body = slide.body;
    pad.X_BP.linear() << -side, 0, 0, 0, 0, -side, 0, 1, 0;
    pad.X_BP.linear().col(0) = pad.X_BP.linear().col(1).cross(pad.X_BP.linear().col(2));
    pad.X_BP.translation().y() = -side * 0.006;
    scene.pads.push_back(pad);
  }
  return scene;
}

inline EngineScene double_pendulum(double step) {
  EngineScene scene;
  scene.step = step;
  // Both rods stretched out sideways.
  scene.bodies = {box(0.3, {0.4, 0.02, 0.02}, {0.2, 0, 0}),
                  box(0.2, {0.3, 0.02, 0.02}, {0.55, 0, 0})};
  for (EngineBody& body : scene.bodies) body.collides = false;
  scene.joints = {hinge(-1, 0, Eigen::Vector3d::Zero()), hinge(0, 1, {0.4, 0, 0})};
  return scene;
}

/// Equations of motion written out for two rods on hinges (l1 = 0.4 m, centres at a1 = 0.2, a2 =
// 0.15 m), integrated by Runge and Kutta's method of fourth order.
inline Eigen::Vector2d double_pendulum_reference(double seconds) {
  const double m1 = 0.3, m2 = 0.2, l1 = 0.4, a1 = 0.2, a2 = 0.15, g = 9.81;
  const double I1 = m1 / 12 * (0.16 + 4e-4), I2 = m2 / 12 * (0.09 + 4e-4);
  // Angles of the rods from the horizontal, downwards; both absolute.
  const auto rate = [&](const Eigen::Vector4d& y) {
    const double c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]);
    Eigen::Matrix2d M;
    M << I1 + m1 * a1 * a1 + m2 * l1 * l1, m2 * l1 * a2 * c, m2 * l1 * a2 * c, I2 + m2 * a2 * a2;
    const Eigen::Vector2d right(
        (m1 * a1 + m2 * l1) * g * std::cos(y[0]) - m2 * l1 * a2 * s * y[3] * y[3],
        m2 * a2 * g * std::cos(y[1]) + m2 * l1 * a2 * s * y[2] * y[2]);
    Eigen::Vector4d dy;
    dy << y[2], y[3], M.inverse() * right;
    return dy;
  };
  Eigen::Vector4d y = Eigen::Vector4d::Zero();
  const int steps = 10000;
  const double h = seconds / steps;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector4d k1 = rate(y), k2 = rate(y + 0.5 * h * k1), k3 = rate(y + 0.5 * h * k2),
                          k4 = rate(y + h * k3);
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return {y[0], y[1] - y[0]};  // as joints count
}

}  // namespace prehend::simulation::engines
