#pragma once

#include <map>
#include <string>

#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/simulation/robot_runner.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Publishes what arm and hand feel, and the ground truth: /clock, /joint_states, /wrench 100 Hz;
/// /tactile/PAD for each pad of the hand, /ground_truth 50 Hz (simulated); /tactile/cells once.
class RobotPublisher {
 public:
  RobotPublisher(graph::Node& node, const robot::HandModel& hand);
  void publish(const RobotReadings& readings);
  void publish_clock(std::int64_t stamp, const graph::ClockPacer::State& pace);

 private:
  struct Pad {
    robot::TactilePadModel model;
    graph::Publisher<msgs::TactileFrame> publisher;
  };
  graph::Publisher<msgs::Clock> clock_;
  graph::Publisher<msgs::JointState> joints_;
  graph::Publisher<msgs::Wrench> wrench_;
  graph::Publisher<msgs::GroundTruth> truth_;
  graph::Publisher<msgs::TactileCells> cells_;
  std::map<std::string, Pad> pads_;
};

}  // namespace prehend::nodes
