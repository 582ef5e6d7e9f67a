#include "eval/touch/hold.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace prehend::eval::touch {

using namespace simulation::engines;

namespace {

constexpr double kCube = 0.05, kHoldFriction = 0.8, kHoldGravity = 9.81, kHoldSafety = 1.2;
constexpr double kPressed = 0.25;                         // s
constexpr double kWeightBegins = 0.5, kWeightEnds = 1.0;  // s
constexpr double kShakeEnds = 1.5;                        // s
constexpr double kDropped = 0.005;                        // m

// From 0 to 1 without a jump of force or its rate.
double smooth(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

}  // namespace

EngineScene hold_scene(const HoldTest& test) {
  EngineScene scene;
  scene.step = test.step;
  scene.gravity = {0, 0, -kHoldGravity};
  scene.solver = test.solver;
  EngineBody cube;
  cube.name = "cube";
  cube.mass = test.mass;
  cube.friction = kHoldFriction;
  cube.shape.size.setConstant(kCube);
  scene.bodies.push_back(cube);
  for (const int side : {1, -1}) {
    EngineBody jaw;
    jaw.name = side > 0 ? "left jaw" : "right jaw";
    jaw.mass = test.jaw_mass;
    jaw.friction = kHoldFriction;
    jaw.shape.size = {0.024, 0.012, 0.05};
    // It touches from the start, so that coarse steps do not shoot it through the cube.
    const double face = 0.5 * kCube - 1e-6;
    jaw.X_WB.translation().y() = side * (face + 0.006);
    scene.bodies.push_back(jaw);
    EngineJoint slide;
    slide.body = static_cast<int>(scene.bodies.size()) - 1;
    slide.axis_W = Eigen::Vector3d(0, -side, 0);
    scene.joints.push_back(slide);
    if (!test.pads) continue;
    EnginePad pad;
    pad.body = slide.body;
    pad.X_BP.linear().col(2) = Eigen::Vector3d(0, -side, 0);
    pad.X_BP.linear().col(1) = Eigen::Vector3d::UnitZ();
    pad.X_BP.linear().col(0) = Eigen::Vector3d::UnitZ().cross(Eigen::Vector3d(0, -side, 0));
    pad.X_BP.translation().y() = -side * 0.006;
    pad.law.static_friction = pad.law.dynamic_friction = kHoldFriction;
    pad.law.bristle_law = contact::BristleLaw::kElastoPlastic;
    pad.law.return_map = true;
    scene.pads.push_back(pad);
  }
  return scene;
}

namespace {

// The forces of the test at time t [s]; jaws close, the lift bears the cube at first.
void press_and_load(Engine& engine, const HoldTest& test, double t, double shake) {
  const double weight = test.mass * kHoldGravity,
               press = kHoldSafety * weight / (2 * kHoldFriction);
  for (const int joint : {0, 1}) engine.set_joint_force(joint, smooth(t / kPressed) * press);
  Vector6 wrench = Vector6::Zero();
  wrench[2] = weight * (1 - smooth((t - kWeightBegins) / (kWeightEnds - kWeightBegins)));
  if (t > kWeightEnds && t < kShakeEnds) {
    wrench[0] = shake * weight * std::sin(2 * M_PI * 5 * (t - kWeightEnds));
    wrench[2] = shake * weight * std::sin(2 * M_PI * 7 * (t - kWeightEnds));
  }
  engine.set_body_wrench(0, wrench);
}

}  // namespace

FeltRun shaken_hold(Engine& engine, const HoldTest& test) {
  constexpr double kShake = 0.1, kPeriod = 0.01;
  const long steps = std::lround(kShakenDuration / test.step);
  const long each = std::max(1L, std::lround(kPeriod / test.step));
  const contact::PadGrid grid;
  FeltRun felt;
  for (long i = 0; i < steps; ++i) {
    press_and_load(engine, test, static_cast<double>(i) * test.step, kShake);
    engine.step();
    if ((i + 1) % each != 0) continue;
    felt.path.push_back(engine.body(0).X_WB.translation());
    if (!test.pads) continue;
    felt.frames.emplace_back();
    for (const int pad : {0, 1}) {
      felt.frames.back().push_back({grid.rows, grid.columns, engine.pad_forces(pad)});
    }
  }
  return felt;
}

HoldResult run_hold(Engine& engine, const HoldTest& test) {
  engine.load(hold_scene(test));
  const auto steps = static_cast<long>(std::lround(test.duration / test.step));
  HoldResult result;
  double at_start = 0, at_middle = 0, squares = 0;
  long middle_steps = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (long i = 0; i < steps; ++i) {
    const double t = static_cast<double>(i) * test.step;
    if (t <= kWeightEnds + test.step) press_and_load(engine, test, t, 0);
    engine.step();
    if (t < kWeightEnds || (i % 10 != 0 && i + 1 != steps)) continue;
    const BodyMotion cube = engine.body(0);
    const double z = cube.X_WB.translation().z();
    if (at_start == 0) at_start = z;
    if (t < 0.5 * test.duration) {
      at_middle = z;
      continue;
    }
    squares += cube.velocity.squaredNorm();
    ++middle_steps;
    result.slip = at_middle - z;
    result.held = at_start - z < kDropped && std::isfinite(z);
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  result.step_time = wall.count() / static_cast<double>(steps);
  result.creep = result.slip / (0.5 * test.duration);
  result.jitter = std::sqrt(squares / static_cast<double>(std::max(1L, middle_steps)));
  return result;
}

}  // namespace prehend::eval::touch
