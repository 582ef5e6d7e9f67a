#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "msgs/convert/geometry.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/clock_pacer.h"
#include "prehend/simulation/robot_world.h"

// Messages that every simulated robot publishes alike.
namespace prehend::nodes {

inline msgs::Clock clock_message(std::int64_t stamp, const graph::ClockPacer::State& pace) {
  msgs::Clock clock;
  clock.set_time(stamp);
  clock.set_speed(pace.paused ? 0 : pace.speed);
  return clock;
}

inline msgs::JointState joints_message(std::int64_t stamp,
                                       const std::vector<simulation::JointReading>& joints) {
  msgs::JointState message;
  message.mutable_header()->set_stamp(stamp);
  for (const simulation::JointReading& joint : joints) {
    message.add_name(joint.name);
    message.add_position(joint.position);
    message.add_velocity(joint.velocity);
    message.add_effort(joint.effort);
  }
  return message;
}

inline msgs::Wrench wrench_message(std::int64_t stamp, const std::string& frame_id,
                                   const simulation::ContactWrench& wrench) {
  msgs::Wrench message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id(frame_id);
  *message.mutable_wrench()->mutable_force() = convert::to_message(wrench.force);
  *message.mutable_wrench()->mutable_torque() = convert::to_message(wrench.torque);
  message.set_biased(true);
  return message;
}

}  // namespace prehend::nodes
