#pragma once

#include <string>
#include <vector>

#include "prehend/grasp/planner.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/robot/hand_model.h"
#include "prehend/text/knob.h"

// What would help where there is no grasp: found by planning again with one thing changed.
namespace prehend::planning {

/// What was changed when it was planned again.
enum class RemedyChange {
  kOpening,     // m, of a parallel gripper
  kFriction,    // assumed between hand and object
  kForce,       // N, of each pad
  kMass,        // kg, of the object
  kMotors,      // factor of the torque or force of every joint of a hand with fingers
  kAir,         // m, between the object and the table
  kNeighbours,  // 1: the other objects are there, 0: they are not
  kApproach,    // 0: one direction, 1: any that the arm reaches, 2: any
  kWorkspace,   // m, by which it is larger on every side
  kPlace,       // m, by which the object is moved
};
/// "opening".
const char* to_string(RemedyChange change);

/// One change, or two together, with which there are grasps where there were none. With less of a
/// change that has steps (1 mm of opening or air, 1 N, 0.05 of friction, a twentieth of the mass, a
/// tenth of the motors, 10 mm of workspace, 50 mm of place) there are none, as far as more of it
/// never takes a grasp away.
struct Remedy {
  struct Amount {
    RemedyChange change = RemedyChange::kOpening;
    double planned = 0;  // with this there is no grasp
    double needed = 0;   // with this there are `grasps`
  };
  std::vector<Amount> amounts;
  int grasps = 0;    // candidates that pass every test then, without those that are the same
  std::string text;  // "with 6 mm more opening (75 mm): 212 grasps"
};

struct RemedyOptions {
  double budget = 0;  // s of wall time, >= 0; 0: none are looked for

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    visit(text::Knob{"remedy_budget", self.budget, "s", 0, 3600,
                     "where there is no grasp: for finding out what would help, by planning again "
                     "with other openings, forces, masses, ...; 0: it is not"});
  }
};

struct Remedies {
  std::vector<Remedy> found;
  std::vector<std::string> in_vain;  // the most of each change that was tried and did not help
  bool complete = true;              // all that the ledger suggests was tried within the budget
};

/// The best of them in a sentence to add to why there is no grasp: "It would help: with ...; with
/// ...", or what does not help; empty: nothing was tried.
std::string in_words(const Remedies& remedies);

/// What would give grasps where plan_grasps() with the same arguments gave none. Only what its
/// ledger names is changed: where candidates were too wide the opening, where the hand would hit
/// the table the air under the object, and so on; the ledger's nearest miss is tried first, then
/// the least amount is found by bisection. When no change helps alone, pairs are
/// tried: each with what the ledger names then. Every
/// figure is counted by plan_grasps() with the changed inputs. (The direction of kPlace is the one
/// in which the arm reaches most of the grasps that the hand has without it.) Robustness is not
/// assessed, sections that are too wide do not count, the object has `density` as a whole, but for
/// kMass, which begins with `hollow_share` of it.
///
/// The same input gives the same remedies in the same order; a budget that is used up leaves out
/// the last of them, never parts of one (Remedies::complete). What another look
/// would change is decision.h's.
/// @param ledger of the plan without grasps.
/// @throws as plan_grasps(); std::invalid_argument for a budget out of range.
Remedies remedies_for_grasps(const surface::ObjectModel& object, const geometry::Plane& table_W,
                             const grasp::Obstacles& obstacles, const robot::HandModel& hand,
                             const grasp::Reachability& reachability,
                             const grasp::PlannerOptions& options,
                             const std::vector<grasp::Rejection>& ledger,
                             const RemedyOptions& remedy_options);

/// What would let the arm execute one of `grasps` where plan_platform_pick() with the same
/// arguments found no motion: nothing beside the object, or the object moved on the table by 0.1 or
/// 0.2 m in one of eight directions. Each is planned by plan_platform_pick(); Remedy::grasps is 1,
/// the grasp that is executed. Random planners may miss a way within their own budget: what is
/// found is so, what is not may be.
/// @throws as plan_platform_pick(); std::invalid_argument for a budget out of range.
Remedies remedies_for_motion(const robot::Platform& platform, const robot::Positions& start,
                             const std::vector<PlatformGrasp>& grasps, const PlatformScene& scene,
                             const PlatformPickOptions& options,
                             const RemedyOptions& remedy_options);

}  // namespace prehend::planning
