#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/grasp.pb.h"
#include "nodes/arm_cycle/arm_ports.h"
#include "nodes/look_again/look_again.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Runs control::ArmCycle on the plans of one view whose grasps have the arm's motion.
class ArmCycleNode {
 public:
  explicit ArmCycleNode(graph::Node& node);

  /// 0 success, 2 failure, 3 nothing can be grasped.
  int exit_code() const { return exit_code_; }

 private:
  struct View {
    Plans plans;  // by object
    std::chrono::steady_clock::time_point newest{};
  };

  void tick();
  /// The newest view, seen at the stamp `since` [ns] or later, whose plans have come.
  const View* newest_ready(std::int64_t since) const;
  struct Choice {
    std::uint32_t object = 0;
    std::vector<control::ArmGrasp> grasps;
    std::string problem;      // of each object
    bool planned = false;     // there are grasps, if only without a way for the arm
    bool known = false;       // the object asked for is in the view
    std::string destination;  // of the first grasp, in words
  };
  /// Among all objects, or the one with the id `object` when that is >= 0.
  Choice choose(const View& view, int object) const;
  void start(const View& view);
  /// After a failed attempt: takes the plan of what was seen `since` [s], when it is there.
  void look_again(double since);
  void publish_progress();
  void finish(const control::CycleResult& result, bool ungraspable);
  msgs::Surprise to_message(const control::Surprise& surprise) const;

  graph::Node& node_;
  int object_;
  bool exits_;
  std::chrono::duration<double> patience_;
  LookAgain look_;
  control::ArmCycleOptions options_;
  ArmActions arm_;
  HandActions hand_;
  control::ArmCycle cycle_;
  graph::Publisher<msgs::Surprise> surprises_;
  graph::Publisher<msgs::CycleState> states_;
  graph::Publisher<msgs::CycleResult> results_;
  std::vector<graph::Subscription> subscriptions_;
  graph::Service start_service_;
  graph::Node::Timer timer_;

  std::map<std::int64_t, View> views_;  // by stamp [ns]; the newest few
  std::shared_ptr<const msgs::JointState> joints_;
  std::optional<Eigen::Vector3d> wrist_force_;  // N
  std::int64_t wrist_stamp_ = 0;                // ns
  std::uint32_t target_ = 0;
  Eigen::Vector3d centroid_W_ = Eigen::Vector3d::Zero();  // m, predicted, of the target
  bool armed_ = true, running_ = false;
  std::string last_detail_;
  std::size_t surprises_sent_ = 0;
  std::optional<std::chrono::steady_clock::time_point> exit_time_;
  int exit_code_ = 2;
};

}  // namespace prehend::nodes
