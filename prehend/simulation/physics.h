#pragma once

#include <string>

#include "prehend/contact/grasp_stepper.h"

namespace prehend::simulation {

/// What a World leaves out or simplifies. Each rule has a test against the full model (all false)
/// in tests/simulation/model_rules_test.cpp; `prehend explain SCENE` says what they do to a scene.
struct ModelRules {
  /// No ray of a pad is cast at a body whose bounds the pad cannot reach in the step. Bitwise
  /// equal.
  bool gate_texels = true;
  /// Triangles that rays met are remembered while nothing moves by 4 nm. Bitwise equal.
  bool remember_triangles = true;
  /// Bodies whose bounds neither meet one another's nor the gripper's are not searched for
  /// touching points. Bitwise equal.
  bool skip_distant_pairs = true;
  /// A body that stands on the table alone and moved at less than 0.2 mm/s for 0.3 s stands still
  /// until something that moves comes to touch it. Error: what it would still have settled,
  /// measured below 2e-5 m; a ball that rolls more slowly than that is stopped, without a bound.
  bool sleep = true;
  /// A body that stands stably where the gripper never comes within the carrier's limits sleeps
  /// from the start. Error: how far it would have sunk into the table, m g / (n 1e5 N/m) for n
  /// points that carry it.
  bool out_of_reach = true;
  /// Pads and other objects' points meet boxes, balls and cans as what they are, not as their
  /// meshes. Error: none for boxes; the sagitta of a segment for balls and cans (r (1 -
  /// cos(pi/n))), and up to 2 mm within 2 mm of a can's rims, which the mesh has bevelled.
  bool primitives = true;
  /// Pads without texels: stiff boxes with the pads' friction. There is then no touch to read.
  /// Error: what the foam gives way, F / (N k) at each pad, 0.26 mm for 22 N.
  bool rigid_pads = false;

  /// The full model, for the twin tests.
  static ModelRules none() { return {false, false, false, false, false, false, false}; }
};

/// How a World is integrated and what it models.
struct PhysicsOptions {
  /// native, or a plug-in that has objects and table while the gripper stays native's: WorldEngine.
  /// A plug-in has boxes, cans and balls, and meshes in convex pieces; it steps as it does
  /// (first_order here), and can neither be saved nor restored; its objects do not sleep.
  std::string engine = "native";
  std::string solver;  // one of the plug-in's, empty: its first
  /// kFirstOrder: backward Euler; kSecondOrder: SDIRK2, see GraspStepper; twice the work a step.
  contact::Integration integration = contact::Integration::kFirstOrder;
  /// Steps of second order, as long as `tolerance` allows: see World::advance.
  bool adaptive = false;
  double tolerance = 1e-5;           // m, > 0
  double velocity_tolerance = 1e-9;  // m/s, see contact::SolveOptions
  int most_iterations = 6;
  ModelRules rules;
};

}  // namespace prehend::simulation
