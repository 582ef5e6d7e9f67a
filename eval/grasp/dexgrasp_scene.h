#pragma once

#include <vector>

#include "eval/grasp/dexgrasp_trial.h"

namespace prehend::eval {

/// A position loop of one joint that moves by itself. Positions from where the hand opens.
struct DexServo {
  int joint = 0;         // of the scene
  double touch = 0;      // rad or m, where the plan says that it touches
  double squeezed = 0;   // the same, so far beyond that it presses with `effort` there
  double stiffness = 0;  // N m/rad or N/m
  double damping = 0;    // N m s/rad or N s/m
  double effort = 0;     // N m or N, at most
};

/// The hand, open, at the grasp's pose, and the object.
struct DexScene {
  simulation::engines::EngineScene scene;
  int object = 0;           // body
  std::vector<int> hand;    // body of the scene of each of the hand's
  int carrier = -1;         // joint along z that lifts the hand; -1: it stands
  double carried_mass = 0;  // kg, on that joint
  std::vector<DexServo> servos;
};

DexScene dex_scene(const DexHand& hand, const DexObject& object, const grasp::Grasp& grasp,
                   DexTest test, const DexProtocol& protocol);

}  // namespace prehend::eval
