#include "eval/touch/slip_hold.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "eval/touch/stage_cycle.h"
#include "prehend/control/cycle_in_world.h"
#include "prehend/control/stage_in_world.h"
#include "prehend/robot/closing_way.h"
#include "prehend/simulation/shapes.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval::touch {
namespace {

using control::JointTrajectory;
using control::SurpriseKind;
using simulation::PadSide;

constexpr double kRaised = 0.1;            // m
constexpr double kAboveHeld = 0.12;        // m, where the approach begins
constexpr double kStageAcceleration = 15;  // m/s^2: an arm's, so that loads can grow
constexpr double kStaticRatio = 8.0 / 7;   // static over dynamic friction of the PG70's pads
constexpr double kShakeTime = 2.5;         // s
constexpr double kDropped = 0.03;          // m, of motion in the gripper
constexpr int kRays = 3;                   // of a texel that feels over its area, along each side
constexpr const char* kTask = R"(
description: lift, shake and hold one object, and put it back
start: look
states:
  look: {do: look, done: approach, otherwise: failure}
  approach: {do: approach, done: grasp, failed: let_go}
  grasp: {do: grasp, done: lift, failed: let_go}
  lift: {do: lift, done: shake, otherwise: let_go}
  shake: {do: move, done: hold, nothing: hold, otherwise: let_go}
  hold: {do: wait, seconds: 1, done: success}
  let_go: {do: release, done: back, failed: back}
  back: {do: retreat, done: failure, failed: failure}
)";

// A prism along y whose top is aslant, on z = 0.
geometry::TriangleMesh slanted_box(const Eigen::Vector3d& size, double slant) {
  geometry::TriangleMesh mesh = simulation::make_standing_box(size);
  for (Eigen::Vector3d& v : mesh.vertices) {
    if (v.z() > size.z() / 2) v.z() += v.x() * std::tan(slant);
  }
  return mesh;
}

geometry::TriangleMesh mesh_of(const SlipHold& hold) {
  switch (hold.shape) {
    case HeldShape::kBall:
      return simulation::make_ball(hold.size.x() / 2);
    case HeldShape::kCan:
      return simulation::make_can(hold.size.x() / 2, hold.size.z());
    case HeldShape::kBottle:
      return simulation::make_bottle(hold.size.x() / 2, hold.size.z());
    case HeldShape::kBox:
    case HeldShape::kSlanted:
    case HeldShape::kCoveringBox:
      break;
  }
  return slanted_box(hold.size, hold.slant);
}

simulation::Scene held_scene(const robot::Platform& platform, const SlipHold& hold) {
  simulation::Scene scene;
  scene.gripper = *platform.hand.gripper;
  if (hold.area_texels) {
    scene.gripper.pad.rows *= kRays;
    scene.gripper.pad.columns *= kRays;
    scene.gripper.pad.texel_pitch /= kRays;
    scene.gripper.pad.newton_per_count /= kRays * kRays;
  }
  scene.carrier = simulation::carrier_of(platform, "side");
  scene.drive = simulation::drive_of(scene.gripper, simulation::pg70_drive());
  if (hold.stuck_drive) {
    scene.drive.static_friction += kHiddenStiction / 3;
    scene.drive.coulomb_friction += kHiddenStiction / 3;
  }
  if (hold.realistic_pads) {
    scene.tactile.foam = contact::FoamMemory::realistic();
    if (!hold.area_texels) {
      const int threshold = scene.tactile.sensor.threshold;
      scene.tactile.sensor = simulation::TactileSensorOptions::realistic();
      scene.tactile.sensor.threshold = threshold;
      scene.tactile.sensor.seed = hold.seed;
    }
  }
  if (hold.wrist_noise > 0) {
    scene.wrench.emplace();
    scene.wrench->force_noise = hold.wrist_noise;
    scene.wrench->seed = hold.seed;
  }
  return scene;
}

// A stage whose pads' rays are more than their texels: what electronics say of the texels.
class HeldStage : public control::CycleWorld {
 public:
  HeldStage(simulation::World& world, const robot::Platform& platform, const SlipHold& hold,
            const robot::TactilePadModel& pad)
      : stage_(world, platform, "side"), area_texels_(hold.area_texels), pad_(pad) {
    simulation::TactileSensorOptions options;
    if (hold.realistic_pads) options = simulation::TactileSensorOptions::realistic();
    options.rows = pad.rows;
    options.columns = pad.columns;
    options.texel_pitch = pad.texel_pitch;
    options.threshold = 0;
    for (std::uint32_t k = 0; k < 2; ++k) {
      options.seed = hold.seed + k;
      sensors_.emplace_back(options);
      felt_.push_back(
          std::make_shared<prehend::touch::FeltPad>(prehend::touch::felt_pad(pad, k == 1)));
    }
  }
  void advance(int steps) override { stage_.advance(steps); }
  double step_time() const override { return stage_.step_time(); }
  double time() const override { return stage_.time(); }
  control::ArmPort& arm() override { return stage_.arm(); }
  control::HandPort& hand() override { return stage_.hand(); }
  control::ArmPercepts percepts(int touch_counts) override {
    control::ArmPercepts percepts = stage_.percepts(touch_counts);
    if (!area_texels_) return percepts;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto reading = sensors_[k].sample(forces(percepts.frames[k].counts), time() - time_);
      percepts.pads[k].sum = reading.sum;
      percepts.pads[k].area = robot::touched_area(reading.counts, touch_counts, felt_[k]->layout);
      percepts.frames[k].felt = felt_[k];
      percepts.frames[k].counts.assign(reading.counts.begin(), reading.counts.end());
    }
    time_ = time();
    return percepts;
  }

 private:
  std::vector<double> forces(const std::vector<double>& rays) const {
    std::vector<double> sums(static_cast<std::size_t>(pad_.rows * pad_.columns), 0.0);
    const int columns = pad_.columns * kRays;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const int row = static_cast<int>(i) / columns, column = static_cast<int>(i) % columns;
      sums[static_cast<std::size_t>(row / kRays * pad_.columns + column / kRays)] +=
          rays[i] * pad_.newton_per_count / (kRays * kRays);
    }
    return sums;
  }

  control::StageInWorld stage_;
  bool area_texels_;
  robot::TactilePadModel pad_;
  std::vector<simulation::TactileSensor> sensors_;
  std::vector<std::shared_ptr<const prehend::touch::FeltPad>> felt_;
  double time_ = 0;  // s, of the last frame
};

// Up and down, ever more; at rest at both ends.
JointTrajectory shaking(const std::vector<double>& about, const SlipHold& hold) {
  constexpr int kPoints = 500;
  const double rate = 2 * std::numbers::pi * hold.frequency;
  JointTrajectory path{{"arm_x", "arm_y", "arm_z", "arm_yaw"}, {}};
  const auto height = [&](double t) {
    const double s = t / kShakeTime;
    const double envelope = s < 0.8 ? s / 0.8 : (1 - s) / 0.2;
    const double smooth = envelope * envelope * (3 - 2 * envelope);
    return hold.shaking / (rate * rate) * smooth * std::sin(rate * t);
  };
  for (int i = 0; i <= kPoints; ++i) {
    const double t = kShakeTime * i / kPoints, h = 1e-5;
    std::vector<double> at = about, speed(about.size(), 0.0);
    at[2] += height(t);
    if (i > 0 && i < kPoints) speed[2] = (height(t + h) - height(t - h)) / (2 * h);
    path.points.push_back({t, at, speed, {}});
  }
  return path;
}

control::ArmGrasp held_grasp(const robot::Platform& platform, const SlipHold& hold) {
  const robot::Positions side = platform.home("side").arm;
  const double z = hold.pad_height, x = hold.beside;
  const std::vector<double> home(side.begin(), side.end()), above{x, 0, z + kAboveHeld, 0},
      there{x, 0, z, 0}, lifted{x, 0, z + kRaised, 0};
  control::ArmGrasp grasp;
  using motion::SegmentKind;
  grasp.segments = {{SegmentKind::kReach, stage_way(home, above)},
                    {SegmentKind::kApproach, stage_way(above, there)},
                    {SegmentKind::kLift, stage_way(there, lifted)}};
  // The cycle carries to a place, for which the shaking stands.
  if (hold.shaking > 0) {
    grasp.segments.emplace_back(SegmentKind::kCarry, shaking(lifted, hold));
    grasp.segments.emplace_back(SegmentKind::kPlace, stage_way(lifted, there));
  }
  grasp.hand_joints = {"hand_opening"};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  const double widest = platform.hand.gripper->max_opening / 2;
  grasp.hand = {one(widest), one(hold.size.y() / 2), one(-robot::kJawLever), one(0), one(widest)};
  grasp.force = hold.force;
  grasp.score = 1;
  return grasp;
}

// N/m, of the bristles of the texels that touch, both pads.
double bristles(const simulation::World& world) {
  const robot::TactilePadModel& pad = world.scene().gripper.pad;
  int touched = 0;
  for (const auto side : {PadSide::kLeft, PadSide::kRight}) {
    for (const auto count : world.tactile_image(side).counts) touched += count > 0 ? 1 : 0;
  }
  const double scale = pad.texel_pitch * pad.texel_pitch / contact::kReferenceTexelArea;
  return std::max(1, touched) * scale * pad.law.bristle_stiffness;
}

}  // namespace

std::string to_string(HeldShape shape) {
  switch (shape) {
    case HeldShape::kBox:
      return "box, an edge on the pads";
    case HeldShape::kSlanted:
      return "box, its edge aslant";
    case HeldShape::kBall:
      return "ball";
    case HeldShape::kCan:
      return "standing can";
    case HeldShape::kBottle:
      return "bottle";
    case HeldShape::kCoveringBox:
      return "box that covers the pads";
  }
  return "unknown";
}

std::string to_string(HoldKind kind) {
  switch (kind) {
    case HoldKind::kSlipsWhenLifted:
      return "slips when lifted";
    case HoldKind::kSlipsWhenShaken:
      return "slips when the load grows";
    case HoldKind::kHeldStill:
      return "held still";
    case HoldKind::kHeldShaken:
      return "held while shaken";
  }
  return "unknown";
}

SlipHold random_slip_hold(HeldShape shape, HoldKind kind, std::uint32_t seed) {
  std::mt19937 random(seed * 7919 + static_cast<std::uint32_t>(shape) * 101 +
                      static_cast<std::uint32_t>(kind));
  const auto between = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  SlipHold hold;
  hold.shape = shape;
  hold.kind = kind;
  hold.seed = seed;
  const double pad_length = robot::TactilePadModel().length();
  const double lowest = pad_length / 2 + 0.004;  // fingers reach below the pads
  hold.size = {between(0.025, 0.08), between(0.02, 0.06), between(0.055, 0.1)};
  hold.beside = between(-0.005, 0.005);
  if (shape == HeldShape::kBall || shape == HeldShape::kCan || shape == HeldShape::kBottle) {
    hold.size.x() = hold.size.y() = between(0.032, 0.062);
  }
  const double coverage = between(0.3, 0.9);
  hold.pad_height = std::max(lowest, hold.size.z() + (0.5 - coverage) * pad_length);
  if (shape == HeldShape::kSlanted) hold.slant = between(0.05, 0.3) * (random() % 2 ? 1 : -1);
  if (shape == HeldShape::kBall) {
    hold.beside = between(-0.003, 0.003);
    hold.pad_height = std::max(lowest, hold.size.x() / 2 + between(-0.005, 0.01));
  }
  if (shape == HeldShape::kBottle) hold.size.z() = between(0.12, 0.18);
  // Where the round shoulder, or the body's upper end, is on the pads.
  if (shape == HeldShape::kBottle) hold.pad_height = 0.6 * hold.size.z() + between(-0.01, 0.01);
  if (shape == HeldShape::kCoveringBox) {
    hold.size = {between(0.035, 0.08), between(0.02, 0.06), between(0.09, 0.12)};
    hold.pad_height = hold.size.z() / 2;
  }
  hold.friction = between(0.25, 0.75);
  hold.force = between(6, 25);
  hold.realistic_pads = random() % 2 == 0;
  hold.stuck_drive = random() % 3 == 0;
  hold.wrist_noise = between(0, 0.15);
  hold.frequency = between(1.5, 4);
  double load = 0;  // of what static friction bears
  switch (kind) {
    case HoldKind::kSlipsWhenLifted:
      load = between(1.08, 1.6);
      break;
    case HoldKind::kSlipsWhenShaken:
      load = between(0.6, 0.85);
      hold.shaking = 9.81 * (1.3 / load - 1);
      break;
    case HoldKind::kHeldStill:
      load = between(0.2, 0.8);
      break;
    case HoldKind::kHeldShaken:
      load = between(0.2, 0.7);
      hold.shaking = std::min(6.0, between(0.1, 0.9) * 9.81 * (0.8 / load - 1));
      break;
  }
  // What a stage's joint is fast enough for.
  hold.frequency = std::max(hold.frequency, hold.shaking / (2 * std::numbers::pi * 0.35));
  hold.mass = load * kStaticRatio * hold.friction * 2 * hold.force / 9.81;
  return hold;
}

SlipHoldResult run_slip_hold(const SlipHold& hold, bool reacts,
                             const prehend::touch::HoldSlipOptions& slip) {
  robot::Platform platform = robot::read_platform(text::tree_file("config/robots/stage_pg70.yaml"));
  platform.acceleration.setConstant(kStageAcceleration);
  const simulation::Scene scene = held_scene(platform, hold);
  const robot::TactilePadModel pad = platform.hand.gripper->pad;
  platform.hand.gripper = scene.gripper;
  simulation::World world(scene);
  world.add_object("held", mesh_of(hold), hold.mass, false, hold.friction);
  HeldStage stage(world, platform, hold, pad);
  control::ArmCycleOptions options;
  options.task = control::parse_task(kTask, "the task of held objects");
  options.largest_attempts = 1;
  options.collision_force = 1000;  // what is shaken is no collision
  options.slip = slip;
  if (!reacts) options.slip_force_factor = 1;
  control::CycleInWorld run(stage, options);
  SlipHoldResult result;
  std::optional<geometry::RigidTransform> X_GB_start;
  double load_start = 0;
  bool ended = false;
  const auto watch = [&] {
    const control::ArmCycle& cycle = run.cycle();
    const control::Phase phase = cycle.phase();
    const bool holds = phase == control::Phase::kLift || phase == control::Phase::kMove;
    const auto reading = world.body("held");
    const geometry::RigidTransform X_GB = world.carrier().X_WG.inverse() * reading.X_WB;
    const Eigen::Vector3d load = world.wrist_wrench().force;
    if (holds && !X_GB_start) {
      X_GB_start = X_GB;
      load_start = load.z();
      result.gripped = true;
    }
    ended = ended || (X_GB_start && phase == control::Phase::kRelease);
    result.put_down = result.put_down || cycle.detail() == "putting down what slips";
    if (!X_GB_start || ended || result.put_down) return;
    if (reading.touches_left_pad && reading.touches_right_pad) {
      const Eigen::Vector3d moved = X_GB.translation() - X_GB_start->translation();
      const double stretch = std::abs(load.z() - load_start) / bristles(world);
      result.slide = std::max(result.slide, std::hypot(moved.x(), moved.z()) - stretch);
      if (std::hypot(moved.x(), moved.z()) > kDropped) result.dropped = true;
    } else {
      result.dropped = true;
      result.slide = std::max(result.slide, kDropped);
    }
    if (result.slide >= 0.003 && !result.passed_3mm) result.passed_3mm = world.time();
    const auto& said = cycle.surprises();
    const bool told = std::any_of(said.begin(), said.end(), [](const auto& surprise) {
      return surprise.kind == SurpriseKind::kSlip;
    });
    if (told && !result.told_at) {
      result.told_at = result.slide;
      result.told_time = world.time();
    }
    result.force = robot::mean_touch(run.percepts().pads, 0.3, 1).sum;
  };
  result.cycle = run.run({{held_grasp(platform, hold)}, ""}, nullptr, watch);
  return result;
}

}  // namespace prehend::eval::touch
