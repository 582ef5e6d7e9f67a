#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include "drivers/wire/hand/hand_axes.h"
#include "drivers/wire/hand/hand_plant.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// The plant is the simulated hand elsewhere in the graph: follows its joints on
/// /world/joint_states and commands them by /world/hand/command, 100 times a second.
template <std::size_t kCount>
class GraphHand : public HandPlant<kCount> {
 public:
  using Drive = typename HandPlant<kCount>::Drive;
  using Motion = typename HandPlant<kCount>::Motion;

  GraphHand(graph::Node& node, const HandAxes& axes, graph::Publisher<msgs::JointCommand> publisher)
      : node_(node),
        axes_(axes),
        followers_(axes.followers().size()),
        publisher_(std::move(publisher)),
        subscription_(node.subscribe<msgs::JointState>(
            "/world/joint_states", graph::QoS::queue(20),
            [this](const graph::Received<msgs::JointState>& state) { take(*state); })) {}

  void command(const std::array<Drive, kCount>& drives) override {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < kCount; ++i) {
      const bool is_led = drives_[i].powered || keeps_lead(i);
      if (drives[i].powered && !is_led) lead_[i] = motion_.position[i];
    }
    drives_ = drives;
  }
  Motion advance(double seconds) override {
    msgs::JointCommand moving, standing;
    Motion motion;
    {
      const std::lock_guard lock(mutex_);
      motion = motion_;
      since_sent_ += seconds;
      if (since_sent_ < kPeriod || last_stamp_ == 0) return motion;
      since_sent_ = 0;
      for (std::size_t i = 0; i < kCount; ++i) {
        const bool moves = (drives_[i].powered || keeps_lead(i)) && !is_stuck_;
        (moves ? moving : standing).add_joint_name(axes_.joints()[i]);
        if (moves) moving.add_value(std::clamp(lead_[i], axes_.lower(i), axes_.upper(i)));
      }
    }
    moving.set_mode(msgs::JointCommand::POSITION);
    standing.set_mode(msgs::JointCommand::STOP);
    for (msgs::JointCommand* message : {&moving, &standing}) {
      if (message->joint_name_size() == 0) continue;
      message->mutable_header()->set_stamp(node_.clock().now());
      publisher_.publish(*message);
    }
    return motion;
  }
  /// Goes nowhere from now on, whatever it is told.
  void set_stuck(bool stuck) {
    const std::lock_guard lock(mutex_);
    is_stuck_ = stuck;
  }

 private:
  static constexpr double kPeriod = 0.01;  // s between commands
  // Share of the current limit over which an axis slows down.
  static constexpr double kSoftening = 0.5;

  bool keeps_lead(std::size_t axis) const { return drives_[axis].self_locking && has_lead_[axis]; }

  void take(const msgs::JointState& state) {
    const std::lock_guard lock(mutex_);
    const std::int64_t stamp = state.header().stamp();
    // The first one, and those of a simulation begun anew, begin where time stands.
    const double passed =
        last_stamp_ > 0 ? 1e-9 * static_cast<double>(std::max<std::int64_t>(0, stamp - last_stamp_))
                        : 0.0;
    last_stamp_ = stamp;
    motion_.time += passed;
    const int count = std::min(
        {state.name_size(), state.position_size(), state.velocity_size(), state.effort_size()});
    std::array<bool, kCount> is_told{};
    for (int i = 0; i < count; ++i) {
      if (const auto axis = axes_.axis_named(state.name(i))) {
        is_told[*axis] = true;
        motion_.joint[*axis] = motion_.position[*axis] = state.position(i);
        motion_.velocity[*axis] = state.velocity(i);
        motion_.current[*axis] = axes_.current_of(*axis, state.effort(i));
      }
      for (std::size_t k = 0; k < followers_.size(); ++k) {
        if (state.name(i) != "hand_" + axes_.followers()[k].joint) continue;
        followers_[k] = {state.position(i), state.velocity(i)};
      }
    }
    for (std::size_t k = 0; k < followers_.size(); ++k) {
      const HandAxes::Follower& follower = axes_.followers()[k];
      const std::size_t axis = follower.axis;
      if (!is_told[axis]) continue;
      motion_.position[axis] = follower.motor(motion_.joint[axis], followers_[k].first);
      motion_.velocity[axis] = follower.motor(motion_.velocity[axis], followers_[k].second);
    }
    for (std::size_t axis = 0; axis < kCount; ++axis) {
      if (is_told[axis]) lead(axis, passed);
    }
  }

  // A motor slows down as its current nears the limit, and then presses: the simulated joint's loop
  // gives way by what its lead is ahead, so that the lead stands where the limit is reached. Its
  // gear holds against what pushes back; one that locks by itself keeps the lead without power.
  void lead(std::size_t axis, double seconds) {
    const Drive& drive = drives_[axis];
    double& lead = lead_[axis];
    if (!drive.powered && keeps_lead(axis) && !is_stuck_) return;
    has_lead_[axis] = true;
    if (!drive.powered || is_stuck_) {
      lead = motion_.position[axis];
      return;
    }
    const double way = drive.position - lead;
    const double load =
        drive.current > 0 ? std::copysign(1.0, way) * motion_.current[axis] / drive.current : 1.0;
    const double pace = std::clamp((1 - load) / kSoftening, 0.0, 1.0);
    const double most = pace * drive.speed * seconds;
    lead = std::clamp(lead + std::clamp(way, -most, most), axes_.lower(axis), axes_.upper(axis));
  }

  graph::Node& node_;
  const HandAxes& axes_;
  std::mutex mutex_;  // guards what follows
  std::array<Drive, kCount> drives_{};
  std::array<double, kCount> lead_{};  // rad, where each axis' loop is led to
  std::array<bool, kCount> has_lead_{};
  Motion motion_;
  std::vector<std::pair<double, double>> followers_;  // rad, rad/s, of axes_.followers()
  std::int64_t last_stamp_ = 0;                       // ns, of the simulation
  bool is_stuck_ = false;
  double since_sent_ = 0;  // s
  graph::Publisher<msgs::JointCommand> publisher_;
  graph::Subscription subscription_;
};

}  // namespace prehend::drivers
