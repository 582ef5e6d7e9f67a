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
    std::map<std::uint32_t, std::shared_ptr<const msgs::GraspPlan>> plans;  // by object
    std::chrono::steady_clock::time_point newest{};
  };

  void tick();
  const View* newest_ready() const;
  void start(const View& view);
  control::ArmGrasp grasp_of(const msgs::Grasp& grasp) const;
  void publish_progress();
  void finish(const control::CycleResult& result, bool ungraspable);
  msgs::Surprise to_message(const control::Surprise& surprise) const;

  graph::Node& node_;
  int object_;
  bool exits_;
  std::chrono::duration<double> patience_;
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
  std::optional<double> wrist_force_;  // N
  std::uint32_t target_ = 0;
  bool armed_ = true, running_ = false;
  std::string last_detail_;
  std::size_t surprises_sent_ = 0;
  std::optional<std::chrono::steady_clock::time_point> exit_time_;
  int exit_code_ = 2;
};

}  // namespace prehend::nodes
