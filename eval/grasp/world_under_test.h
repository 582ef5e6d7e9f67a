#pragma once

#include <memory>
#include <string>

#include "eval/grasp/trial_setup.h"
#include "prehend/control/cycle_world.h"
#include "prehend/robot/platform.h"
#include "prehend/simulation/sensors/pad_electronics.h"

namespace prehend::eval {

/// The object of a trial, as it truly is.
struct ObjectReading {
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  geometry::RigidTransform X_HB = geometry::RigidTransform::Identity();  // in the hand
  double height = 0;  // m, of its lowest point over the table
  bool touches_robot = false;
};

/// A platform at one of its homes, the object of a trial, and what else is there, simulated as the
/// node simulation does: by World and its stage where a gripper's drive moves the hand, else by
/// RobotWorld. The wrist has the noise of an FT 300.
class WorldUnderTest {
 public:
  virtual ~WorldUnderTest() = default;
  virtual control::CycleWorld& robot() = 0;
  virtual ObjectReading object() const = 0;
};

/// @param tactile the pads' electronics, ideal by default.
/// @throws as the world's constructor and its add_object().
std::unique_ptr<WorldUnderTest> world_under_test(const robot::Platform& platform,
                                                 const std::string& home, const TrueObject& truth,
                                                 const simulation::TactileOptions& tactile = {});

}  // namespace prehend::eval
