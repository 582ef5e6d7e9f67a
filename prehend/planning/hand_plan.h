#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/grasp/hand_planner.h"
#include "prehend/grasp/planner.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/surface/object_model.h"

// One way to ask for grasps, whichever hand closes.
namespace prehend::planning {

/// A ranked grasp of any hand.
struct PlannedGrasp {
  PlatformGrasp pose;          // its `expected_success` is the score
  Eigen::VectorXd closed;      // rad or m, of the hand's motors, where it touches
  Eigen::VectorXd all;         // the same of all joints of the hand's model
  double roll = 0;             // rad, about the approach
  double force = 0;            // N, per pad; 0: the motors' limits set it
  double effort = 0;           // share of what the hand can, with the safety factor
  double score = 0;            // what the list is ranked by, 0 to 1
  double quality = 0;          // epsilon, see grasp/wrench_hull.h
  double robustness = -1;      // share of disturbed trials in which it holds; -1: not assessed
  double guessed_contact = 0;  // share of the contact on surface that nobody saw
  grasp::PredictedPercepts predicted;       // of fingers only the lifted mass
  std::vector<Eigen::Vector3d> contacts_W;  // m
  std::string generator;                    // whose candidate it was
  std::string remark;                       // what to know of it, in words; often empty
  std::optional<grasp::Grasp> pads;         // of a parallel gripper: the same as its planner has it
};

struct HandPlanResult {
  std::vector<PlannedGrasp> grasps;          // best first
  std::vector<grasp::Rejection> rejections;  // where the other candidates fell
  int candidates = 0;                        // = grasps + all rejections
  std::string problem;           // "cannot be grasped: ..." when there is no grasp, else empty
  grasp::Remembered remembered;  // what the database had to do with it
};

/// Of the two ways to close, that which the hand has counts.
struct HandPlanOptions {
  grasp::PlannerOptions pads;         // of a parallel gripper: HandModel::gripper
  grasp::HandPlannerOptions fingers;  // of all other hands
};

/// Plans grasps of one object with a hand: by plan_grasps() where it is a parallel gripper with
/// pads, else by plan_hand_grasps(); with a `database` and a `known` object with their memory.
/// @throws as these.
HandPlanResult plan_hand(const grasp::HandToClose& hand, const surface::ObjectModel& object,
                         const geometry::Plane& table, const grasp::Obstacles& obstacles,
                         const grasp::Reachability& reachability, const HandPlanOptions& options,
                         grasp::GraspDatabase* database = nullptr,
                         const std::optional<grasp::PlacedObject>& known = std::nullopt);

/// With the direction of approach of a platform that can take no other
/// (Platform::fixed_approach()), where none is given.
grasp::Reachability within_reach(grasp::Reachability reachability, const robot::Platform& platform);

/// The options with an arm that must reach each grasp and its pregrasp (arm_reach()).
HandPlanOptions within_reach(HandPlanOptions options, const robot::Platform& platform);

}  // namespace prehend::planning
