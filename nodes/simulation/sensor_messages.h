#pragma once

#include "msgs/sensors.pb.h"
#include "nodes/simulation/simulated_robot.h"
#include "prehend/graph/node.h"
#include "prehend/simulation/scene.h"

namespace prehend::nodes {

/// Publishes readings as the topics a real robot has, and the ground truth:
/// /clock, /joint_states, /gripper/state, /wrench 100 Hz; /tactile/left, /tactile/right,
/// /ground_truth 50 Hz (simulated). Without texels (physics.pads: rigid) there is
/// no /tactile.
class SensorPublisher {
 public:
  SensorPublisher(graph::Node& node, const simulation::Scene& scene);
  void publish(const SensorReadings& readings);
  void publish_clock(std::int64_t stamp, const graph::ClockPacer::State& pace);

 private:
  msgs::TactileFrame tactile(const simulation::TactileImage& image, std::int64_t stamp,
                             const char* frame_id) const;

  robot::TactilePadModel pad_;
  bool has_touch_;
  graph::Publisher<msgs::Clock> clock_;
  graph::Publisher<msgs::JointState> joints_;
  graph::Publisher<msgs::GripperState> gripper_;
  graph::Publisher<msgs::TactileFrame> left_, right_;
  graph::Publisher<msgs::Wrench> wrench_;
  graph::Publisher<msgs::GroundTruth> truth_;
};

}  // namespace prehend::nodes
