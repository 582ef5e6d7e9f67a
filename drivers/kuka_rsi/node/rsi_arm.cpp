#include "drivers/kuka_rsi/node/rsi_arm.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace prehend::drivers::kuka_rsi {
namespace {

using Status = simulation::ArmDrive::Status;

robot::Positions positions_of(const Axes& axes) {
  return Eigen::Map<const Eigen::Matrix<double, kAxes, 1>>(axes.data());
}

Status status_of(Snapshot::End end) {
  switch (end) {
    case Snapshot::End::kNone:
      return Status::kIdle;
    case Snapshot::End::kRunning:
      return Status::kMoving;
    case Snapshot::End::kReached:
      return Status::kReached;
    case Snapshot::End::kStopped:
    case Snapshot::End::kContact:
      return Status::kStopped;
    case Snapshot::End::kOffPath:
      return Status::kOffPath;
  }
  return Status::kIdle;
}

// Why the arm takes no motion now.
std::string obstacle(const Snapshot& now) {
  if (now.latched) return "the arm was stopped by /arm/fast_stop; acknowledge it first";
  if (now.state == State::kSilent) return "no controller sends: RSI is off, or the network";
  if (now.state == State::kRefused) {
    return std::string("the controller is not answered: ") + to_string(now.refusal);
  }
  return std::string("the arm is ") + to_string(now.state);
}

}  // namespace

void RsiArm::stop_arm(std::uint64_t ticket) {
  if (ticket == ticket_) device_.stop();
}

void RsiArm::follow(const simulation::TrajectoryRequest& request,
                    const std::vector<double>& tolerance, double contact_force) {
  const Snapshot now = device_.snapshot();
  if (now.latched || now.state != kuka_rsi::State::kHolding)
    throw std::invalid_argument(obstacle(now));
  if (!tolerance.empty() && tolerance.size() != kAxes) {
    throw std::invalid_argument("path_tolerance is empty or one number a joint");
  }
  auto motion = std::make_unique<Motion>();
  for (std::size_t i = 0; i < kAxes; ++i) {
    motion->tolerance[i] = tolerance.empty() ? path_tolerance_ : tolerance[i];
    if (!(motion->tolerance[i] > 0 && std::isfinite(motion->tolerance[i]))) {
      throw std::invalid_argument("path_tolerance must be positive");
    }
  }
  motion->contact_force = contact_force;
  motion->set_points =
      set_points_of(check_trajectory(limits_.chain(), request, positions_of(now.set_point)),
                    now.set_point, now.reference, limits_, cycle_);
  const std::lock_guard lock(mutex_);
  motion->ticket = ++motions_;
  if (!device_.start(std::move(motion))) throw std::invalid_argument(obstacle(device_.snapshot()));
}

nodes::MovedArm::State RsiArm::arm_state() {
  const Snapshot now = device_.snapshot();
  std::uint64_t handed_over = 0;
  {
    const std::lock_guard lock(mutex_);
    handed_over = motions_;
  }
  State state;
  // What was handed over a moment ago may not have been told yet.
  state.status = now.ticket == handed_over ? status_of(now.end) : Status::kMoving;
  const bool moves =
      now.state == kuka_rsi::State::kMoving || now.state == kuka_rsi::State::kStopping;
  state.at_rest = !moves;
  state.contact = now.end == Snapshot::End::kContact;
  state.time = now.time;
  state.largest_error = now.largest_error;
  state.desired = positions_of(now.set_point);
  state.actual = positions_of(now.actual);
  state.reason = words_of(now);
  return state;
}

std::string RsiArm::words_of(const Snapshot& now) const {
  const auto joint = [&] { return limits_.chain().joints()[now.broken.axis].name; };
  switch (now.reason) {
    case Reason::kNone:
    case Reason::kAsked:
    case Reason::kContact:
      return {};  // ArmAction has words for these
    case Reason::kOffPath:
      return fmt::format("joint '{}' is {:.4f} off the path after {:.2f} s", joint(), now.off,
                         now.time);
    case Reason::kNotThere:
      return fmt::format("joint '{}' is still {:.4f} from the goal", joint(), now.off);
    case Reason::kLimit:
      return fmt::format("stopped: joint '{}' {}", joint(), to_string(now.broken.breach));
    default:
      return to_string(now.reason);
  }
}

void RsiArm::wait_for_slice() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }

}  // namespace prehend::drivers::kuka_rsi
