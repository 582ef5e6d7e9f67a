#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "prehend/contact/shape.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/simulation/tactile_sensor.h"
#include "prehend/touch/felt_pad.h"

// Things between the PG70's pads, by the contact library's stepper and the pads' electronics.
namespace prehend::eval::touch {

struct PressOptions {
  double force = 20;            // N, of each jaw
  bool realistic = false;       // TactileSensorOptions::realistic(), each pad its own
  bool held = false;            // the thing does not move; otherwise it floats between the pads
  double mass = 0.3;            // kg
  double step = 1e-3;           // s
  double opening_noise = 5e-5;  // m, standard deviation, of realistic pads' grippers
  std::uint32_t seed = 1;       // of the pads: this one and the next
};

struct Pressed {
  double opening = 0;                                // m, as the gripper says
  std::array<std::vector<std::uint16_t>, 2> frames;  // of the pads at +y and -y
  std::array<std::vector<std::uint16_t>, 2> again;   // the same a moment later: noise
};

/// Two pads that press one thing after the other, and remember what pads remember.
class Presser {
 public:
  explicit Presser(const PressOptions& options);

  const prehend::touch::FeltPad& pad() const { return pad_; }

  /// Closes the jaws, whose direction is y and whose middle is the origin, on `shape` at X_GB.
  /// Nothing when it does not fit between the open jaws or a pad feels less than half the force.
  std::optional<Pressed> press(const contact::Shape& shape, const geometry::RigidTransform& X_GB);

 private:
  PressOptions options_;
  robot::GripperModel gripper_;
  prehend::touch::FeltPad pad_;
  std::vector<simulation::TactileSensor> sensors_;
  std::mt19937 random_{17};
};

}  // namespace prehend::eval::touch
