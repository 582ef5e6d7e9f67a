#pragma once

#include <string>
#include <vector>

#include "prehend/grasp/known/grasp_database.h"
#include "prehend/grasp/planner.h"
#include "prehend/robot/hand_model.h"

namespace prehend::grasp {

/// An object whose mesh is known, where it stands.
struct PlacedObject {
  std::string hash;  // content_hash() of its mesh
  std::string name;  // for people
  geometry::RigidTransform X_WO = geometry::RigidTransform::Identity();
};

/// What a plan has to do with the database.
struct Remembered {
  int stored = 0;       // grasps that the database had
  bool reused = false;  // the plan is made of them
};

/// plan_grasps() with a memory: the grasps that `database` has of the object are the only
/// candidates (each is tested for reach, collisions and hold as every candidate, so poses that do
/// not serve here fall away), their scores times (successes + 1) / (attempts + 1) of what was
/// executed. When there are none, or none serves here, all candidates are tried and the grasps
/// found are added to the database, but for those within 5 mm and 0.1 rad of one that it has. A
/// stored grasp of a hand with fingers belongs to the preshape that has its open positions; one
/// that belongs to none is left out.
/// @throws as plan_grasps() and GraspDatabase.
GraspPlan plan_grasps_with_memory(GraspDatabase& database, const PlacedObject& placed,
                                  const surface::ObjectModel& object, const geometry::Plane& table,
                                  const Obstacles& obstacles, const HandToClose& hand,
                                  const Reachability& reachability, const PlannerOptions& options,
                                  Remembered* remembered = nullptr);

/// Under which the database has the hand's grasps: the hand's name, of a parallel gripper the
/// gripper's.
const std::string& remembered_as(const robot::HandModel& hand);

/// Counts that the grasp at X_WG was executed, and whether it held.
/// @return false when the database has no grasps of the object with this hand.
bool remember_execution(GraspDatabase& database, const PlacedObject& placed,
                        const std::string& hand, const geometry::RigidTransform& X_WG, bool held);

}  // namespace prehend::grasp
