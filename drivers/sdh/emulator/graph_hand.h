#pragma once

#include <cstdint>
#include <mutex>

#include "drivers/sdh/emulator/hand_plant.h"
#include "drivers/sdh/node/hand_axes.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::sdh {

/// The plant is the simulated hand elsewhere in the graph: follows its joints on
/// /world/joint_states and commands them by /world/hand/command, 100 times a second.
class GraphHand : public HandPlant {
 public:
  GraphHand(graph::Node& node, const HandAxes& axes,
            graph::Publisher<msgs::JointCommand> publisher);
  void command(const std::array<Drive, kAxes>& drives) override;
  Motion advance(double seconds) override;
  /// Goes nowhere from now on, whatever it is told.
  void set_stuck(bool stuck);

 private:
  void take(const msgs::JointState& state);
  void lead(std::size_t axis, double seconds);

  graph::Node& node_;
  const HandAxes& axes_;
  std::mutex mutex_;  // guards what follows
  std::array<Drive, kAxes> drives_{};
  AxisValues lead_{};  // rad, where each axis' loop is led to
  Motion motion_;
  std::int64_t last_stamp_ = 0;  // ns, of the simulation
  bool is_stuck_ = false;
  double since_sent_ = 0;  // s
  graph::Publisher<msgs::JointCommand> publisher_;
  graph::Subscription subscription_;
};

}  // namespace prehend::drivers::sdh
