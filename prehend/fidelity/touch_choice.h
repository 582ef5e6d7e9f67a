#pragma once

#include <filesystem>
#include <string>

#include "prehend/fidelity/front.h"
#include "prehend/robot/platform.h"
#include "prehend/simulation/scene.h"

// The choice from the measured fronts of touch, for whoever simulates a robot.
namespace prehend::fidelity {

/// What is asked of a simulated world. Exactly one of budget and tolerance is above 0 where one is
/// asked for at all.
struct TouchRequest {
  std::filesystem::path front;  // empty: the shipped one of the kind of world
  double budget = 0;            // s of processor for each simulated second, >= 0; 0: none
  /// Share of the largest sum of a pad, >= 0, by which the pads' images may differ from a finer
  /// run's, root mean square; 0: none.
  double tolerance = 0;

  bool is_asked() const { return budget > 0 || tolerance > 0; }
};

/// World: a parallel gripper on its carrier; RobotWorld: arms with hands, and hands alone, measured
/// with the SDH-2.
enum class TouchWorld { kWorld, kRobotWorld };

struct ChosenTouch {
  Setting setting;
  std::string text;  // knobs, what they measured, and the file, for people
};

/// @pre request.is_asked(). @throws UnreachableError naming the nearest setting;
/// geometry::InputError when both are asked for, or the front cannot be read or is of another
/// subject than "touch" (World) or "touch_hand" (RobotWorld).
ChosenTouch choose_touch(const TouchRequest& request, TouchWorld world);

/// Chooses for the world in which `platform` is simulated, and sets how `scene` is. @throws as
/// choose_touch(); geometry::InputError for a hand without pads, and with file and line of what the
/// scene itself says of what is chosen, or with what no front was measured: another engine, rigid
/// pads.
ChosenTouch choose_touch(const TouchRequest& request, const robot::Platform& platform,
                         simulation::Scene* scene);

}  // namespace prehend::fidelity
