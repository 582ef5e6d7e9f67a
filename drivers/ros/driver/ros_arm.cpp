#include "drivers/ros/driver/ros_arm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {
namespace {

using recording::RosValue;
using Fields = RosValue::Fields;
using List = RosValue::List;

RosValue duration_of(double seconds) {
  return ros::ros_duration(static_cast<std::int64_t>(std::llround(1e9 * seconds)));
}

/// Of what stays where it is until the message is written.
RosValue numbers_of(const robot::Positions& values) {
  return ros::ros_numbers(values.data(), static_cast<std::size_t>(values.size()));
}

std::string why_of(GoalEnd end, const RosValue* result, const std::string& text) {
  // control_msgs/FollowJointTrajectory's results
  constexpr std::array<const char*, 6> kCodes = {"",
                                                 "invalid goal",
                                                 "invalid joints",
                                                 "old time in its header",
                                                 "path tolerance violated",
                                                 "goal tolerance violated"};
  std::string why = fmt::format("the arm's action of ROS {}", to_string(end));
  std::string detail = text;
  if (result) {
    const std::int64_t code = -(*result)["error_code"].integer();
    if (code > 0 && code < static_cast<std::int64_t>(kCodes.size())) {
      why += fmt::format(" ({})", kCodes[static_cast<std::size_t>(code)]);
    }
    if (detail.empty()) detail = (*result)["error_string"].text();
  }
  return detail.empty() ? why : why + ": " + detail;
}

}  // namespace

RosArm::RosArm(RosPeer& peer, const Mapping::Arm& options, robot::KinematicChain chain,
               RosProblem tell)
    : options_(options),
      chain_(std::move(chain)),
      tell_(tell),
      joints_(peer, options.joint_states, std::move(tell)),
      action_(action_client(peer, options.action, "control_msgs/FollowJointTrajectory")) {
  for (const auto& [ours, theirs] : options_.joints) {
    const bool is_known =
        std::any_of(chain_.joints().begin(), chain_.joints().end(),
                    [&name = ours](const robot::ChainJoint& joint) { return joint.name == name; });
    if (!is_known) {
      throw std::invalid_argument("the mapping's arm.joints has '" + ours +
                                  "', which is no joint of the platform's arm");
    }
  }
}

std::string RosArm::ros_name(const std::string& joint) const {
  const auto found = options_.joints.find(joint);
  return found == options_.joints.end() ? joint : found->second;
}

std::vector<JointListener::Joint> RosArm::joints() const {
  std::vector<JointListener::Joint> result;
  for (const robot::ChainJoint& joint : chain_.joints()) {
    const auto heard = joints_.joint(ros_name(joint.name), options_.loss_time);
    if (!heard) return {};
    result.push_back(*heard);
  }
  return result;
}

std::optional<robot::Positions> RosArm::positions() const {
  const auto heard = joints();
  if (heard.empty()) return std::nullopt;
  robot::Positions q(static_cast<Eigen::Index>(heard.size()));
  for (std::size_t i = 0; i < heard.size(); ++i)
    q[static_cast<Eigen::Index>(i)] = heard[i].position;
  return q;
}

std::string RosArm::obstacle() const {
  for (const robot::ChainJoint& joint : chain_.joints()) {
    if (!joints_.joint(ros_name(joint.name), options_.loss_time)) {
      return fmt::format("nothing comes of joint '{}' on {} of ROS", ros_name(joint.name),
                         options_.joint_states);
    }
  }
  if (!action_->has_server()) return "no server of ROS has the action " + options_.action;
  return {};
}

std::uint64_t RosArm::take_arm() {
  const std::lock_guard lock(mutex_);
  return ++ticket_;
}

bool RosArm::holds_arm(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  return ticket == ticket_;
}

void RosArm::stop_locked(const std::string& why) {
  if (!runs_) return;
  if (reason_.empty()) reason_ = why;
  status_ = Status::kStopped;
  action_->cancel();
}

void RosArm::stop_arm(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  if (ticket == ticket_) stop_locked("");
}

void RosArm::follow(const simulation::TrajectoryRequest& request,
                    const std::vector<double>& tolerance, double contact_force) {
  const std::string why = obstacle();
  const auto q = positions();
  if (!why.empty() || !q) throw std::invalid_argument(why);
  const auto count = chain_.joints().size();
  if (!tolerance.empty() && tolerance.size() != count) {
    throw std::invalid_argument("path_tolerance is empty or one number a joint");
  }
  simulation::ArmTrajectory trajectory = check_trajectory(chain_, request, *q);
  List points, tolerances;
  for (const auto& point : trajectory.points) {
    Fields fields{{"positions", numbers_of(point.position)},
                  {"time_from_start", duration_of(point.time)}};
    if (trajectory.has_velocity) fields.emplace_back("velocities", numbers_of(point.velocity));
    if (trajectory.has_acceleration) {
      fields.emplace_back("accelerations", numbers_of(point.acceleration));
    }
    points.emplace_back(std::move(fields));
  }
  std::vector<std::string> names;
  for (const robot::ChainJoint& joint : chain_.joints()) names.push_back(ros_name(joint.name));
  for (std::size_t i = 0; i < tolerance.size(); ++i) {
    if (!(tolerance[i] > 0 && std::isfinite(tolerance[i]))) {
      throw std::invalid_argument("path_tolerance must be positive");
    }
    tolerances.emplace_back(
        Fields{{"name", ros::ros_text(names[i])}, {"position", ros::ros_number(tolerance[i])}});
  }
  // A header without a time: it begins when it comes.
  const RosValue goal(
      Fields{{"trajectory", RosValue(Fields{{"joint_names", ros::ros_texts(names)},
                                            {"points", RosValue(std::move(points))}})},
             {"path_tolerance", RosValue(std::move(tolerances))},
             {"goal_time_tolerance", duration_of(options_.settle_time / 2)}});
  const std::lock_guard lock(mutex_);
  const std::uint64_t motion = ++motion_;
  trajectory_ = std::move(trajectory);
  began_ = Clock::now();
  status_ = Status::kMoving;
  runs_ = true;
  contact_ = false;
  contact_force_ = contact_force;
  largest_error_ = 0;
  reason_.clear();
  action_->send(
      goal, [this, motion](GoalEnd end_of_goal, const RosValue* result, const std::string& text) {
        end(motion, end_of_goal, result, text);
      });
}

void RosArm::end(std::uint64_t motion, GoalEnd end, const RosValue* result,
                 const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (motion != motion_ || !runs_) return;
  runs_ = false;
  if (end == GoalEnd::kSucceeded) {
    if (status_ == Status::kMoving) status_ = Status::kReached;
    return;
  }
  if (status_ == Status::kStopped && end == GoalEnd::kCancelled) return;  // as it was told to
  status_ = end == GoalEnd::kAborted ? Status::kOffPath : Status::kStopped;
  if (reason_.empty()) reason_ = why_of(end, result, text);
}

double RosArm::elapsed() const {
  return std::chrono::duration<double>(Clock::now() - began_).count();
}

nodes::MovedArm::State RosArm::arm_state() {
  const auto q = positions();
  const std::lock_guard lock(mutex_);
  State state;
  state.status = status_;
  state.at_rest = !runs_;
  state.contact = contact_;
  state.reason = reason_;
  const bool has_path = !trajectory_.points.empty();
  state.time = has_path ? std::min(elapsed(), trajectory_.duration()) : 0;
  state.actual = q ? *q : has_path ? trajectory_.points.back().position : chain_.middle();
  state.desired = has_path ? trajectory_.at(state.time).position : state.actual;
  if (q && runs_) {
    largest_error_ = std::max(largest_error_, (state.desired - *q).cwiseAbs().maxCoeff());
  }
  state.largest_error = largest_error_;
  return state;
}

void RosArm::wait_for_slice() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }

void RosArm::feel(double force) {
  const std::lock_guard lock(mutex_);
  if (!runs_ || contact_ || !(contact_force_ > 0) || !(force > contact_force_)) return;
  contact_ = true;
  stop_locked("");
}

void RosArm::look() {
  const std::string why = obstacle();
  const std::lock_guard lock(mutex_);
  if (!runs_) return;
  if (!why.empty() && status_ == Status::kMoving) stop_locked("stopped: " + why);
  const double late = elapsed() - trajectory_.duration();
  if (status_ == Status::kMoving && late > options_.settle_time) {
    stop_locked(fmt::format("the arm's action of ROS did not end {:.1f} s after its trajectory",
                            options_.settle_time));
  }
  // Nobody answers to that either: the motion is given up, and said to be.
  if (late > 2 * options_.settle_time || (!why.empty() && !action_->has_server())) {
    runs_ = false;
    tell_("the arm's action of ROS does not say that the arm stands: " +
          (why.empty() ? reason_ : why));
  }
}

}  // namespace prehend::drivers::ros_link
