#include "nodes/simulation/robot_messages.h"

#include <cstdint>

#include "msgs/convert/geometry.h"
#include "msgs/convert/tactile_cells.h"
#include "nodes/simulation/clock_message.h"

namespace prehend::nodes {

using graph::QoS;

RobotPublisher::RobotPublisher(graph::Node& node, const robot::HandModel& hand)
    : clock_(node.advertise<msgs::Clock>("/clock", QoS::latched(20))),
      joints_(node.advertise<msgs::JointState>("/joint_states", QoS::queue(100))),
      wrench_(node.advertise<msgs::Wrench>("/wrench", QoS::queue(100))),
      truth_(node.advertise<msgs::GroundTruth>("/ground_truth", QoS::latched(50))) {
  if (!hand.pads.empty()) {
    cells_ = node.advertise<msgs::TactileCells>("/tactile/cells", QoS::latched(1));
    cells_.publish(convert::cells_message(hand));
  }
  for (const robot::HandPad& pad : hand.pads) {
    pads_.emplace(pad.name, Pad{pad.model, node.advertise<msgs::TactileFrame>(
                                               "/tactile/" + pad.name, QoS::queue(50))});
  }
}

void RobotPublisher::publish_clock(std::int64_t stamp, const graph::ClockPacer::State& pace) {
  clock_.publish(clock_message(stamp, pace));
}

void RobotPublisher::publish(const RobotReadings& readings) {
  joints_.publish(joints_message(readings.stamp, readings.joints));
  wrench_.publish(wrench_message(readings.stamp, "hand", readings.wrench));
  if (!readings.has_frames) return;
  for (const simulation::HandPadReading& reading : readings.pads) {
    Pad& pad = pads_.at(reading.name);
    msgs::TactileFrame frame;
    frame.mutable_header()->set_stamp(readings.stamp);
    frame.mutable_header()->set_frame_id(reading.name);
    frame.set_rows(static_cast<std::uint32_t>(reading.rows));
    frame.set_columns(static_cast<std::uint32_t>(reading.columns));
    frame.set_texel_width(pad.model.texel_pitch);
    frame.set_texel_height(pad.model.texel_pitch);
    frame.set_full_scale(static_cast<std::uint32_t>(pad.model.full_scale));
    frame.set_newton_per_count(pad.model.newton_per_count);
    for (const std::uint16_t count : reading.counts) frame.add_intensity(count);
    frame.set_sum(reading.sum);
    pad.publisher.publish(frame);
  }
  msgs::GroundTruth truth;
  truth.mutable_header()->set_stamp(readings.stamp);
  truth.mutable_header()->set_frame_id("world");
  for (const simulation::RobotBodyReading& body : readings.bodies) {
    msgs::GroundTruth::Body& out = *truth.add_bodies();
    out.set_name(body.name);
    *out.mutable_x_wb() = convert::to_message(body.X_WB);
    *out.mutable_velocity() = convert::to_message(body.velocity);
    out.set_mass(body.mass);
    out.set_height(body.height);
    out.set_touches_table(body.touches_table);
  }
  truth_.publish(truth);
}

}  // namespace prehend::nodes
