#pragma once

#include <limits>
#include <vector>

#include "eval/grasp/dexgrasp_trial.h"

namespace prehend::eval {

/// A position loop of one joint that moves by itself. Positions from where the hand opens.
struct DexServo {
  int joint = 0;          // of the scene
  double rate = 0;        // rad or m, signed, for each unit of the hand's closing, ...
  double later_rate = 0;  // ... and after `later`: of joints that break away
  double later = std::numeric_limits<double>::infinity();
  double touch = 0;      // rad or m, where the plan says that it touches
  double squeezed = 0;   // the same, so far beyond that it presses as it should
  double stiffness = 0;  // N m/rad or N/m
  double damping = 0;    // N m s/rad or N s/m
  double effort = 0;     // N m or N, at most

  /// Where it is after so much of the closing: as the plan closes the hand, no farther than
  /// `touch`.
  double closed_by(double closing) const;
  /// How much of the closing takes it to `touch`; 0 of what it does not move.
  double closing_to_touch() const;
};

/// The hand, open, at the grasp's pose, and the object.
struct DexScene {
  simulation::engines::EngineScene scene;
  int object = 0;           // body
  std::vector<int> hand;    // body of the scene of each of the hand's
  int carrier = -1;         // joint along z that lifts the hand; -1: it stands
  double carried_mass = 0;  // kg, on that joint
  std::vector<DexServo> servos;
  double closing = 0;  // until all are where they touch
};

DexScene dex_scene(const DexHand& hand, const DexObject& object, const grasp::Grasp& grasp,
                   DexTest test, const DexProtocol& protocol);

}  // namespace prehend::eval
