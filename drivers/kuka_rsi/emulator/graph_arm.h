#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "drivers/kuka_rsi/emulator/arm_plant.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::kuka_rsi {

/// The plant is the simulated arm elsewhere in the graph: follows its /world/joint_states and
/// streams set points to its /world/arm/command, one a cycle.
class GraphArm : public ArmPlant {
 public:
  /// `joints`: A1 to A6, as the graph calls them.
  GraphArm(graph::Node& node, std::vector<std::string> joints);
  void command(const Axes& q) override;
  Axes advance(double seconds) override;
  /// Whether the simulated arm has told where it is.
  bool is_known() const;

 private:
  void take(const msgs::JointState& state);

  graph::Node& node_;
  const std::vector<std::string> joints_;
  mutable std::mutex mutex_;  // guards what follows
  Axes actual_{};
  bool is_known_ = false;
  graph::Publisher<msgs::JointCommand> publisher_;
  graph::Subscription subscription_;
};

}  // namespace prehend::drivers::kuka_rsi
