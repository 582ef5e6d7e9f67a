#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/grasp.pb.h"
#include "nodes/grasp_cycle/ports.h"
#include "nodes/grasp_cycle/view.h"
#include "nodes/gripper_source/gripper_source.h"
#include "nodes/look_again/look_again.h"
#include "prehend/control/grasp_cycle.h"
#include "prehend/graph/node.h"
#include "prehend/planning/free_places.h"

namespace prehend::nodes {

/// Runs control::GraspCycle on the plans of one view with what the devices' topics tell.
class CycleNode {
 public:
  explicit CycleNode(graph::Node& node);

  /// 0 success, 2 failure, 3 nothing can be grasped (0 when that is declared fine).
  int exit_code() const { return exit_code_; }

 private:
  void subscribe();
  void tick();
  /// Starts on `view`; false when it has to wait or has failed.
  void start(const View& view);
  /// Asks the simulation for the predicted objects, one after another, then begins the cycle.
  void spawn_predicted(const View& view, const geometry::RigidTransform& X_SW);
  void spawn_next();
  void take_spawned(std::uint32_t id, const graph::Outcome<msgs::SpawnResponse>& outcome);
  void begin();
  /// True while the robot may still say which gripper it has.
  bool waits_for_gripper();
  /// After a failed attempt: takes the plan of what was seen `since` [s], when it is there.
  void look_again(double since);
  /// The same for a predicted object in the simulation: takes its grasps to where it is `since`.
  void follow_spawned(double since);
  /// `X_moved`: by which the target has moved since it was seen.
  /// @throws geometry::InputError for a place that was given and cannot be used.
  Eigen::Vector3d choose_move(
      const View& view, const Target& target, const geometry::RigidTransform& X_SW,
      const geometry::RigidTransform& X_moved = geometry::RigidTransform::Identity()) const;
  control::Percepts percepts() const;
  void publish_progress();
  /// `grasp_index`: among the target's grasps.
  void publish_state(const std::string& phase, int grasp_index, const std::string& detail);
  /// Takes the grasps of a target that was just chosen as those of its plan.
  void take_target(Target target);
  std::uint32_t plan_index(int grasp_index) const;
  void finish(const control::CycleResult& result, bool ungraspable);
  msgs::Surprise to_message(const control::Surprise& surprise) const;

  graph::Node& node_;
  int object_;
  bool spawns_;
  bool exits_;
  bool ungraspable_is_ok_;
  double density_;  // kg/m^3
  int touch_counts_;
  GripperSource gripper_;
  control::CycleOptions options_;
  planning::PlaceOptions place_;
  double workspace_;  // m
  LookAgain look_;
  ViewCollector views_;
  GripperActions gripper_port_;
  CarrierActions carrier_port_;
  graph::ServiceClient<msgs::SpawnRequest, msgs::SpawnResponse> spawn_;
  graph::Publisher<msgs::Surprise> surprises_;
  graph::Publisher<msgs::CycleState> states_;
  graph::Publisher<msgs::CycleResult> results_;
  std::vector<graph::Subscription> subscriptions_;
  graph::Service start_service_;
  graph::Node::Timer timer_;

  std::shared_ptr<const msgs::TactileFrame> left_, right_;
  std::shared_ptr<const msgs::GripperState> gripper_state_;
  std::shared_ptr<const msgs::GroundTruth> truth_;  // of the simulation that objects are put into
  template <class Value>
  struct Stamped {
    Value value;
    std::int64_t stamp;  // ns
  };
  std::optional<Stamped<geometry::RigidTransform>> carrier_;  // X_WG
  std::optional<Stamped<double>> wrist_;                      // N

  std::optional<control::GraspCycle> cycle_;
  Target target_;
  std::vector<std::uint32_t> plan_index_;  // in the plan, of each of the target's grasps
  Eigen::Vector3d centroid_W_ = Eigen::Vector3d::Zero();  // m, predicted, of the target
  bool armed_ = true;                                     // waits for plans to start on
  bool preparing_ = false;  // objects are being put into the simulation
  bool running_ = false;
  struct Spawn {
    std::uint32_t id = 0;
    msgs::SpawnRequest request;
  };
  std::deque<Spawn> to_spawn_;
  struct Spawned {
    View view;  // that was put into the simulation, at X_SW
    geometry::RigidTransform X_SW = geometry::RigidTransform::Identity();
    std::optional<geometry::RigidTransform> X_SB;  // of the target's body when it was planned on
    geometry::RigidTransform X_moved = geometry::RigidTransform::Identity();  // since it was put in
  };
  Spawned spawned_;
  Eigen::Vector3d move_W_ = Eigen::Vector3d::Zero();  // of the object, when it is lifted
  std::string last_detail_;
  std::size_t surprises_sent_ = 0;
  std::optional<std::chrono::steady_clock::time_point> gripper_patience_;
  std::optional<std::chrono::steady_clock::time_point> exit_time_;
  int exit_code_ = 0;
};

}  // namespace prehend::nodes
