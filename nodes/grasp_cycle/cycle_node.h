#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/belief.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/percepts.pb.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "nodes/grasp_cycle/arm_robot.h"
#include "nodes/grasp_cycle/look_again.h"
#include "nodes/grasp_cycle/predicted_objects.h"
#include "nodes/grasp_cycle/view.h"
#include "nodes/gripper_source/gripper_source.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Runs the cycle of the robot at hand on the plans of one view.
class CycleNode {
 public:
  explicit CycleNode(graph::Node& node);

  /// 0 success, 2 failure, 3 nothing can be grasped (0 when that is declared fine).
  int exit_code() const { return exit_code_; }

 private:
  std::unique_ptr<ArmRobot> declare_robot();
  void subscribe();
  void tick();
  /// True while the robot may still say what it has.
  bool waits_for_robot();
  Target target_in(const View& view, int object) const;
  bool is_settled(const msgs::GraspPlan& plan) const;
  bool is_placed(const msgs::GraspPlan& plan) const;
  static bool is_among(const std::vector<Eigen::Vector3d>& centroids_W,
                       const msgs::GraspPlan& plan);
  void start(const View& view);
  void begin(const std::string& problem = "");
  /// Gets ready to push something of a view without grasps; false: the task does not push, or
  /// nothing is to be pushed.
  bool prepares_push(const View& view, int object);
  /// What is tried from now on.
  void take_target(const View& view, std::uint32_t id);
  /// After a failed attempt: takes the plan of what was seen `since` [s], when it is there.
  void look_again(double since);
  void publish_progress();
  /// What an attempt has found out, once it lifts or has failed.
  void publish_evidence();
  /// What was put at its place, as it was predicted, where it stands now.
  void publish_placed();
  /// What it has perceived, once it has closed, and lifted or not.
  void publish_percepts();
  void publish_state(control::Phase phase, int grasp_index, const std::string& detail);
  void finish(const control::CycleResult& result);
  void fail(const std::string& reason);

  graph::Node& node_;
  int object_;
  int grasp_;
  bool exits_;
  bool ungraspable_is_ok_;
  PredictedObjects predicted_;
  GripperSource gripper_;
  LookAgain look_;
  ViewCollector views_;
  control::Task task_;
  std::unique_ptr<ArmRobot> robot_;
  EmergencyStopListener emergency_;
  graph::Publisher<msgs::Surprise> surprises_;
  graph::Publisher<msgs::CycleState> states_;
  graph::Publisher<msgs::CycleResult> results_;
  graph::Publisher<msgs::Task> tasks_;
  graph::Publisher<msgs::AttemptEvidence> evidence_;
  graph::Publisher<msgs::ActPercepts> percepts_;
  graph::Publisher<msgs::ObjectModel> placed_;
  std::vector<graph::Subscription> subscriptions_;
  graph::Service start_service_, stop_service_;
  graph::Node::Timer timer_;

  std::uint32_t target_ = 0;
  std::shared_ptr<const msgs::GraspPlan> target_plan_;     // of the target
  std::shared_ptr<const msgs::ObjectModel> target_model_;  // null: it has not come
  int placed_sent_ = 0;
  std::int64_t view_stamp_ = 0;  // ns, of the view that its grasps were planned on
  Eigen::Vector3d centroid_W_ = Eigen::Vector3d::Zero();  // m, predicted, of the target
  std::vector<Eigen::Vector3d> given_up_W_;               // m, where objects were given up
  std::vector<Eigen::Vector3d> failed_W_;  // m, where objects lie that were met too early
  bool armed_ = true;                      // waits for plans to start on
  bool preparing_ = false;                 // objects are being put into the simulation
  bool running_ = false;
  std::string last_detail_;
  std::size_t surprises_sent_ = 0;
  int evidence_sent_ = 0, loads_sent_ = 0, looks_sent_ = 0, percepts_sent_ = 0;  // of this cycle
  std::size_t surprises_before_ = 0;  // the present attempt
  std::optional<std::chrono::steady_clock::time_point> robot_patience_;
  std::optional<std::chrono::steady_clock::time_point> exit_time_;
  int exit_code_ = 0;
};

}  // namespace prehend::nodes
