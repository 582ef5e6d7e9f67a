#pragma once

#include <mutex>

#include "drivers/pg70/emulator/gripper_plant.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::pg70 {

/// The plant is the simulated gripper elsewhere in the graph: follows its /world/gripper/state and
/// commands it by /world/gripper/command, 100 times a second.
class GraphGripper : public GripperPlant {
 public:
  explicit GraphGripper(graph::Node& node);
  void command(const Command& command) override;
  Motion advance(double seconds) override;
  /// Commands nothing from now on, so that the simulated jaws stand still.
  void set_stuck(bool stuck);

 private:
  msgs::GripperCommand message() const;

  graph::Node& node_;
  mutable std::mutex mutex_;  // guards what follows
  Command command_;
  Motion motion_;
  std::int64_t last_stamp_ = 0;  // ns, of the simulation
  bool stuck_ = false;
  double since_sent_ = 0;  // s
  graph::Publisher<msgs::GripperCommand> publisher_;
  graph::Subscription subscription_;
};

}  // namespace prehend::drivers::pg70
