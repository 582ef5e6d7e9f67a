#include "eval/touch/pressing.h"

#include "prehend/contact/grasp_stepper.h"
#include "prehend/contact/parallel_grasp.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval::touch {
namespace {

constexpr double kClosingSpeed = 0.1;      // m/s, of each jaw
constexpr double kServo = 2000;            // N s/m
constexpr double kPressTime = 0.7;         // s, of which closing takes at most half
constexpr double kFramePeriod = 1.0 / 30;  // s
constexpr int kFrames = 15;
constexpr double kRest = 5;  // s, unloaded, between presses

}  // namespace

Presser::Presser(const PressOptions& options)
    : options_(options),
      gripper_(robot::read_gripper_model(text::tree_file("config/robots/pg70_dsa.yaml"))),
      pad_(prehend::touch::felt_pad(gripper_.pad)) {
  for (const std::uint32_t seed : {options.seed, options.seed + 1}) {
    simulation::TactileSensorOptions sensor = options.realistic
                                                  ? simulation::TactileSensorOptions::realistic()
                                                  : simulation::TactileSensorOptions{};
    sensor.rows = gripper_.pad.rows;
    sensor.columns = gripper_.pad.columns;
    sensor.newton_per_count = gripper_.pad.newton_per_count;
    sensor.full_scale = gripper_.pad.full_scale;
    sensor.seed = seed;
    sensors_.emplace_back(sensor);
  }
}

std::optional<Pressed> Presser::press(const contact::Shape& shape,
                                      const geometry::RigidTransform& X_GB) {
  contact::ParallelGraspOptions grasp;
  const robot::TactilePadModel& pad = gripper_.pad;
  grasp.pad = {pad.rows, pad.columns, pad.width(), pad.length(), pad.thickness};
  grasp.law = pad.law;
  grasp.mass = options_.mass;
  grasp.opening = gripper_.max_opening;
  contact::GraspModel model = contact::parallel_grasp(grasp);
  model.shape = shape;
  model.gravity.setZero();
  model.body_is_fixed = options_.held;
  model.X_WB = X_GB;
  contact::StepOptions step;
  step.step = options_.step;
  contact::GraspStepper stepper(model, step);
  for (const int jaw : {0, 1}) {
    const contact::GraspState start = stepper.state();
    if (stepper.system().gap(start, 1e-3) <= 0) return std::nullopt;
    contact::SlideCommand command;
    command.damping = kServo;
    command.speed = kClosingSpeed;
    command.limit = options_.force;
    stepper.system().set_command(jaw, command, 0);
  }
  while (stepper.state().time < kPressTime - 1e-9) stepper.step(kPressTime);
  const contact::GraspState& state = stepper.state();
  Pressed pressed;
  pressed.opening = gripper_.max_opening - state.slide_position[0] - state.slide_position[1];
  for (const int jaw : {0, 1}) {
    if (stepper.system().pad_force(state, jaw) < options_.force / 2) return std::nullopt;
  }
  if (options_.realistic) {
    pressed.opening += std::normal_distribution<double>(0, options_.opening_noise)(random_);
  }
  for (const int jaw : {0, 1}) {
    const auto& all = state.pads[jaw].normal_force;
    const std::vector<double> forces(all.begin(),
                                     all.begin() + static_cast<std::ptrdiff_t>(pad_.layout.size()));
    simulation::TactileSensor& sensor = sensors_[jaw];
    for (int i = 0; i < kFrames; ++i) {
      pressed.frames[jaw] = sensor.sample(forces, kFramePeriod).counts;
    }
    pressed.again[jaw] = sensor.sample(forces, kFramePeriod).counts;
    sensor.sample(std::vector<double>(forces.size(), 0.0), kRest);
  }
  return pressed;
}

}  // namespace prehend::eval::touch
