#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "msgs/grasp.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/control/task.h"
#include "prehend/geometry/plane.h"
#include "prehend/planning/hand_plan.h"
#include "prehend/robot/platform.h"
#include "prehend/surface/object_model.h"

namespace prehend::nodes {

/// The other objects of a view, in the world frame.
struct Neighbours {
  std::vector<geometry::TriangleMesh> meshes_W;  // as predicted
  std::vector<geometry::TriangleMesh> pieces_W;  // convex, of the same
};

/// Plans grasps of a platform's hand and the motion of the arm that carries it.
class PlatformPlanning {
 public:
  /// @param home of the platform: where the arm stands.
  /// @param motions how many of the grasps get the arm's motion, > 0: one for each attempt.
  /// @throws geometry::InputError for an unknown home.
  PlatformPlanning(robot::Platform platform, const std::string& home,
                   const planning::HandPlanOptions& grasps, planning::PlatformPickOptions arm,
                   planning::PlaceOptions place, control::Task task, int motions);

  /// Grasps that the arm can execute come first, with their segments; then the others. A plan
  /// without any motion has the arm's reason, or the place's, as its problem. Pads keep from the
  /// neighbours' meshes, fingers and arm from their convex pieces.
  /// @param database of grasps for an object that is `known`; null or unset: all are planned anew.
  /// @throws geometry::InputError for a bad mesh.
  msgs::GraspPlan plan(const surface::ObjectModel& object, const geometry::Plane& table_W,
                       const Neighbours& neighbours, const grasp::Reachability& reachability,
                       grasp::GraspDatabase* database,
                       const std::optional<grasp::PlacedObject>& known) const;

  /// Where the arm stands now: motions start there, or at home while it is within 1 mrad of it.
  /// Without all joints of the arm nothing changes.
  void start_from(const msgs::JointState& joints);

  /// Plans for this gripper, which the robot says it has. @pre says_its_gripper()
  void set_gripper(const robot::GripperModel& gripper);
  /// The robot has a parallel gripper, and says which (/gripper/model).
  bool says_its_gripper() const { return platform_.hand_port == robot::HandPort::kGripper; }

  /// Under which grasps are remembered.
  const std::string& hand() const {
    return platform_.hand.gripper ? platform_.hand.gripper->name : platform_.hand.name;
  }

 private:
  msgs::Grasp to_message(const planning::PlannedGrasp& grasp) const;
  void add_motions(const std::vector<planning::PlannedGrasp>& grasps,
                   const planning::PlatformScene& scene, msgs::GraspPlan* message) const;
  msgs::ArmSegment to_message(const motion::PickSegment& segment) const;

  robot::Platform platform_;
  robot::Positions home_, start_;
  grasp::HandToClose hand_;
  planning::HandPlanOptions options_;
  planning::PlatformPickOptions arm_options_;
  planning::PlaceOptions place_;
  control::Task task_;
  int motions_;
};

}  // namespace prehend::nodes
