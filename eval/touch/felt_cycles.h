#pragma once

#include <array>
#include <string>

#include "eval/touch/felt.h"
#include "prehend/simulation/scene.h"

// Work cycles in the simulated worlds that the nodes run, for what they let pads feel: commands at
// fixed times, so that runs compare; frames and the object's place every 10 ms, as the node
// publishes them.
namespace prehend::eval::touch {

struct CycleRun {
  FeltRun felt;
  double seconds = 0;  // of processor for each simulated second
};

/// What the PG70 grasps in the cycles: a box of 0.1 kg that covers 52 % of the pads' length, a can
/// of 0.3 kg (60 %), a box of 1 kg (100 %).
constexpr int kCycleObjects = 3;
extern const std::array<const char*, kCycleObjects> kCycleNames;

/// The scene of a cycle of World: what ships (config/scenes/demo.yaml's gripper, drive and pads),
/// with ideal pads that count finely enough for their rounding not to be felt.
/// @param rows, columns of texels on a pad of unchanged size and stiffness.
simulation::Scene cycle_scene(int object, int rows = 14, int columns = 6);

/// Closes by 10 mm/s, presses by 12 N or 20 N for each kg, lifts by 0.1 m, holds, puts down, opens
/// and goes: 12 s. @throws as World's constructor.
CycleRun run_gripper_cycle(const simulation::Scene& scene);

/// The same of a hand of config/robots with fingers, alone on its carrier: a box of 60 x 60 x 120
/// mm is gripped as hard as the motors press, lifted by 5 cm, held, put down and let go: 9 s.
/// @throws geometry::InputError for a file that cannot be read.
CycleRun run_hand_cycle(const std::string& hand, double mass, double step);

}  // namespace prehend::eval::touch
