#include "drivers/sdh/emulator/graph_hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace prehend::drivers::sdh {
namespace {

constexpr double kPeriod = 0.01;    // s between commands
constexpr double kSoftening = 0.5;  // share of the current limit over which an axis slows down

}  // namespace

GraphHand::GraphHand(graph::Node& node, const HandAxes& axes,
                     graph::Publisher<msgs::JointCommand> publisher)
    : node_(node),
      axes_(axes),
      publisher_(std::move(publisher)),
      subscription_(node.subscribe<msgs::JointState>(
          "/world/joint_states", graph::QoS::queue(20),
          [this](const graph::Received<msgs::JointState>& state) { take(*state); })) {}

void GraphHand::take(const msgs::JointState& state) {
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
  for (int i = 0; i < count; ++i) {
    const auto axis = axes_.axis_named(state.name(i));
    if (!axis) continue;
    motion_.position[*axis] = state.position(i);
    motion_.velocity[*axis] = state.velocity(i);
    motion_.current[*axis] = axes_.current_of(*axis, state.effort(i));
    lead(*axis, passed);
  }
}

// A motor slows down as its current nears the limit, and then presses: the simulated joint's loop
// gives way by what its lead is ahead, so that the lead stands where the limit is reached. Its gear
// holds against what pushes back.
void GraphHand::lead(std::size_t axis, double seconds) {
  const Drive& drive = drives_[axis];
  double& lead = lead_[axis];
  if (!drive.powered || is_stuck_) {
    lead = motion_.position[axis];
    return;
  }
  const double way = drive.position - lead;
  const double load =
      drive.current > 0 ? std::copysign(1.0, way) * motion_.current[axis] / drive.current : 1.0;
  const double pace = std::clamp((1 - load) / kSoftening, 0.0, 1.0);
  const double most = pace * drive.speed * seconds;
  lead += std::clamp(way, -most, most);
}

void GraphHand::command(const std::array<Drive, kAxes>& drives) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (drives[i].powered && !drives_[i].powered) lead_[i] = motion_.position[i];
  }
  drives_ = drives;
}

void GraphHand::set_stuck(bool stuck) {
  const std::lock_guard lock(mutex_);
  is_stuck_ = stuck;
}

HandPlant::Motion GraphHand::advance(double seconds) {
  msgs::JointCommand moving, standing;
  Motion motion;
  {
    const std::lock_guard lock(mutex_);
    motion = motion_;
    since_sent_ += seconds;
    if (since_sent_ < kPeriod || last_stamp_ == 0) return motion;
    since_sent_ = 0;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const bool moves = drives_[i].powered && !is_stuck_;
      (moves ? moving : standing).add_joint_name(axes_.joints()[i]);
      if (!moves) continue;
      moving.add_value(std::clamp(lead_[i], axes_.limits().lower[i], axes_.limits().upper[i]));
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

}  // namespace prehend::drivers::sdh
