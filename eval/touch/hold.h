#pragma once

#include <string>

#include "eval/touch/felt.h"
#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::eval::touch {

/// A 50 mm cube between two jaws of 50 g on prismatic joints, each pressed with
/// F = 1.2 m g / (2 mu), mu = 0.8. The jaws press on the weightless cube, with their whole force
/// from 0.25 s on; its weight comes on between 0.5 and 1 s.
struct HoldTest {
  double mass = 0.3;       // kg, of the cube
  double jaw_mass = 0.05;  // kg, of each jaw
  double step = 1e-3;      // s
  double duration = 10;    // s
  std::string solver;      // of the engine; empty: its first
  bool pads = false;       // 6 x 14 texels on each jaw; otherwise the jaws are rigid plates
};

struct HoldResult {
  bool held = false;     // sank by less than 5 mm from 1 s to the end
  double slip = 0;       // m, sinking from the middle of the test to its end
  double creep = 0;      // m/s, slip over that time
  double jitter = 0;     // m/s, root mean square of the cube's speed in that time
  double step_time = 0;  // s of wall clock for each step
};

/// Scene of the test: bodies 0 cube, 1 and 2 jaws; joints 0 and 1, positive forces close.
simulation::engines::EngineScene hold_scene(const HoldTest& test);

/// Runs the test. @throws simulation::engines::UnsupportedScene.
HoldResult run_hold(simulation::engines::Engine& engine, const HoldTest& test);

/// A like test of a whole simulation::World on an engine: a box of 48 mm is gripped by the drive,
/// with F = 1.2 m g / (2 mu), mu = 0.7, lifted from the table by 5 cm and held for `duration`. Of
/// `test` mass, step and duration count; pads are texels. @throws as World's constructor.
HoldResult run_world_hold(const std::string& engine, const HoldTest& test);

/// The same of a hand of config/robots with fingers, alone on its carrier: a box of 60 x 60 x 120
/// mm is gripped as hard as the motors press.
struct HandHold {
  HoldResult hold;   // without jitter and step_time
  double bears = 0;  // kg, what friction bears of what the fingers pressed with on the table
};
/// @throws geometry::InputError for a file that cannot be read.
HandHold run_hand_hold(const std::string& hand, const HoldTest& test);
/// Its world, the hand open over the box in its first preshape, and how it closes.
simulation::RobotWorld hand_over_box(const robot::HandModel& hand, double mass, double step);
simulation::HandCommand closing_on_box(const robot::HandModel& hand);

/// Advances a loaded hold_scene for kShakenDuration: pressed and loaded as above, then shaken
/// between 1 and 1.5 s by forces of 0.1 m g at 5 Hz along x and at 7 Hz along z. The cube's centre
/// and, with pads, what they feel every 10 ms, of which the step must be a part.
constexpr double kShakenDuration = 2;  // s
FeltRun shaken_hold(simulation::engines::Engine& engine, const HoldTest& test);

}  // namespace prehend::eval::touch
