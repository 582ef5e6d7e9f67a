#pragma once

#include <string>
#include <vector>

#include "prehend/grasp/grasp_database.h"
#include "prehend/grasp/hand_planner.h"
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
/// found are added to the database, but for those within 5 mm and 0.1 rad of one that it has.
/// @throws as plan_grasps() and GraspDatabase.
GraspPlanResult plan_grasps_with_memory(GraspDatabase& database, const PlacedObject& placed,
                                        const surface::ObjectModel& object,
                                        const geometry::Plane& table, const Obstacles& obstacles,
                                        const robot::GripperModel& gripper,
                                        const Reachability& reachability,
                                        const PlannerOptions& options,
                                        Remembered* remembered = nullptr);

/// The same for plan_hand_grasps(). A stored grasp belongs to the preshape that has its open
/// positions; one that belongs to none is left out.
HandPlan plan_hand_grasps_with_memory(GraspDatabase& database, const PlacedObject& placed,
                                      const surface::ObjectModel& object,
                                      const geometry::Plane& table, const Obstacles& obstacles,
                                      const HandToClose& hand, const Reachability& reachability,
                                      const HandPlannerOptions& options,
                                      Remembered* remembered = nullptr);

/// Counts that the grasp at X_WG was executed, and whether it held.
/// @return false when the database has no grasps of the object with this hand.
bool remember_execution(GraspDatabase& database, const PlacedObject& placed,
                        const std::string& hand, const geometry::RigidTransform& X_WG, bool held);

}  // namespace prehend::grasp
