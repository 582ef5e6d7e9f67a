#include "nodes/simulation/sensor_messages.h"

#include "msgs/convert/geometry.h"
#include "nodes/simulation/clock_message.h"

namespace prehend::nodes {
namespace {

using graph::QoS;

template <class Message>
Message stamped(std::int64_t stamp, const char* frame_id) {
  Message message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id(frame_id);
  return message;
}

msgs::GripperState gripper_message(const SensorReadings& readings) {
  auto message = stamped<msgs::GripperState>(readings.stamp, "gripper");
  message.set_opening(readings.gripper.opening);
  message.set_velocity(readings.gripper.velocity);
  message.set_current(readings.gripper.current);
  message.set_referenced(true);
  message.set_moving(readings.gripper.moving);
  message.set_blocked(readings.gripper.blocked);
  message.set_error_code(readings.gripper_error);
  return message;
}

msgs::GroundTruth truth_message(const SensorReadings& readings) {
  auto message = stamped<msgs::GroundTruth>(readings.stamp, "world");
  for (const simulation::BodyReading& body : readings.bodies) {
    msgs::GroundTruth::Body* out = message.add_bodies();
    out->set_name(body.name);
    *out->mutable_x_wb() = convert::to_message(body.X_WB);
    *out->mutable_velocity() = convert::to_message(body.velocity);
    out->set_mass(body.mass);
    out->set_height(body.height);
    out->set_touches_left_pad(body.touches_left_pad);
    out->set_touches_right_pad(body.touches_right_pad);
    out->set_touches_table(body.touches_table);
  }
  return message;
}

}  // namespace

SensorPublisher::SensorPublisher(graph::Node& node, const simulation::Scene& scene)
    : pad_(scene.gripper.pad),
      has_touch_(!scene.physics.rules.rigid_pads),
      clock_(node.advertise<msgs::Clock>("/clock", QoS::latched(20))),
      joints_(node.advertise<msgs::JointState>("/joint_states", QoS::queue(100))),
      gripper_(node.advertise<msgs::GripperState>("/gripper/state", QoS::queue(100))),
      wrench_(node.advertise<msgs::Wrench>("/wrench", QoS::queue(100))),
      truth_(node.advertise<msgs::GroundTruth>("/ground_truth", QoS::latched(50))) {
  if (!has_touch_) return;
  left_ = node.advertise<msgs::TactileFrame>("/tactile/left", QoS::queue(50));
  right_ = node.advertise<msgs::TactileFrame>("/tactile/right", QoS::queue(50));
}

void SensorPublisher::publish_clock(std::int64_t stamp, const graph::ClockPacer::State& pace) {
  clock_.publish(clock_message(stamp, pace));
}

void SensorPublisher::publish(const SensorReadings& readings) {
  joints_.publish(joints_message(readings.stamp, readings.joints));
  gripper_.publish(gripper_message(readings));
  wrench_.publish(wrench_message(readings.stamp, "gripper", readings.wrench));
  if (!readings.has_frames) return;
  if (has_touch_) {
    left_.publish(tactile(readings.left, readings.stamp, "left_pad"));
    right_.publish(tactile(readings.right, readings.stamp, "right_pad"));
  }
  truth_.publish(truth_message(readings));
}

msgs::TactileFrame SensorPublisher::tactile(const simulation::TactileImage& image,
                                            std::int64_t stamp, const char* frame_id) const {
  auto message = stamped<msgs::TactileFrame>(stamp, frame_id);
  message.set_rows(image.rows);
  message.set_columns(image.columns);
  message.set_texel_width(pad_.texel_pitch);
  message.set_texel_height(pad_.texel_pitch);
  message.set_full_scale(pad_.full_scale);
  for (const std::uint16_t counts : image.counts) message.add_intensity(counts);
  message.set_sum(image.sum);
  message.set_newton_per_count(pad_.newton_per_count);
  return message;
}

}  // namespace prehend::nodes
