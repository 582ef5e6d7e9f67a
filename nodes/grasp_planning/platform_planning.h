#pragma once

#include <optional>
#include <string>
#include <vector>

#include "msgs/grasp.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/control/task.h"
#include "prehend/fidelity/front.h"
#include "prehend/geometry/plane.h"
#include "prehend/grasp/load_bounds.h"
#include "prehend/planning/platform_plan.h"
#include "prehend/robot/platform.h"
#include "prehend/surface/object_model.h"

namespace prehend::nodes {

constexpr const char* kRemediesStage = "remedies";  // of a plan's times

/// Plans grasps of a platform's hand and the motion of the arm that carries it, as messages.
class PlatformPlanning {
 public:
  /// @param home of the platform: where the arm stands.
  /// @param touch what options.touch was chosen by from a front; goes with every plan.
  /// @throws geometry::InputError for an unknown home; std::invalid_argument for options out of
  /// range.
  PlatformPlanning(robot::Platform platform, const std::string& home,
                   planning::PlatformPlanOptions options,
                   const std::optional<fidelity::Setting>& touch, control::Task task);

  /// planning::PlatformPlanner::plan(), with the task's places, what is known of its load, and
  /// where a fingertip would learn most of it. `remedy_budget` [s] is what is left of the view's;
  /// `shape_confidence` and the pushes that were `made`: as PlatformPlanOptions' and
  /// PushPlanOptions'.
  /// @throws geometry::InputError for a bad mesh, or an object that has no place in the task.
  msgs::GraspPlan plan(const surface::ObjectModel& object, const geometry::Plane& table_W,
                       const planning::Neighbours& neighbours,
                       const grasp::Reachability& reachability, grasp::GraspDatabase* database,
                       const std::optional<grasp::PlacedObject>& known,
                       const grasp::LoadBounds& load, const std::vector<planning::ProbeWay>& probes,
                       double shape_confidence, const std::vector<planning::PushLine>& made,
                       double remedy_budget) const;

  /// For finding out what would help the objects of a view that have no grasp, together [s].
  double remedy_budget() const { return options_.remedies.budget; }

  /// Where the arm stands now: motions start there, or at home while it is within 1 mrad of it.
  /// Without all joints of the arm nothing changes.
  void start_from(const msgs::JointState& joints);

  /// The task shows what is held to a camera: its plans have views, once view_by() was told of one.
  bool inspects() const { return task_.does(control::Primitive::kInspect); }
  /// The arm carries a camera, and the task may look from elsewhere with it: its plans say how,
  /// once view_by() was told of one.
  bool looks() const {
    const bool asks =
        task_.does(control::Primitive::kDecide) || task_.does(control::Primitive::kView);
    return asks && planner_.platform().X_FC;
  }
  /// The camera that looks at the table. Of one that does not say where it stands, plans have no
  /// views of what is held, and say so. @throws geometry::InputError for a camera that is none.
  void view_by(const msgs::CameraInfo& camera);

  /// Plans for this gripper, which the robot says it has. @pre says_its_gripper()
  void set_gripper(const robot::GripperModel& gripper);
  /// The robot has a parallel gripper, and says which (/gripper/model).
  bool says_its_gripper() const {
    return planner_.platform().hand_port == robot::HandPort::kGripper;
  }

  /// Under which grasps are remembered.
  const std::string& hand() const { return grasp::remembered_as(planner_.platform().hand); }

 private:
  msgs::Grasp to_message(const planning::PlannedPick& pick) const;

  robot::Positions home_, start_;
  planning::PlatformPlanner planner_;
  planning::PlatformPlanOptions options_;
  std::optional<msgs::FidelityChoice> touch_fidelity_;
  control::Task task_;
};

}  // namespace prehend::nodes
