#include "tools/calibrate/arm_and_camera.h"

#include <signal.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "msgs/convert/images.h"
#include "prehend/text/nearest_match.h"
#include "tools/arm_goal.h"
#include "tools/command_node.h"

namespace prehend::tools {
namespace {

using std::chrono::steady_clock;

constexpr auto kTurn = std::chrono::milliseconds(50);
constexpr std::int64_t kRest = 300'000'000;  // ns: so long the arm stands before an image counts
constexpr double kStill = 1e-4;              // rad or m
constexpr std::size_t kMostStates = 4000;

std::atomic<bool> interrupted = false;

void interrupt(int) { interrupted = true; }

// The first signal is noticed, a second one has its default effect.
void notice_interrupts() {
  interrupted = false;
  struct sigaction action = {};
  action.sa_handler = interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

ArmAndCamera::ArmAndCamera(const std::string& registry, const robot::KinematicChain& chain,
                           double patience)
    : chain_(chain), patience_(patience), node_(command_node("calibrate", registry)) {
  notice_interrupts();
  joints_ = node_.subscribe<msgs::JointState>(
      "/joint_states", graph::QoS::queue(200),
      [this](const graph::Received<msgs::JointState>& state) { take(*state); });
  infos_ = node_.subscribe<msgs::CameraInfo>("/camera/info", graph::QoS::latched(1),
                                             [this](const graph::Received<msgs::CameraInfo>& info) {
                                               const std::lock_guard lock(mutex_);
                                               info_ = *info;
                                               came_.notify_all();
                                             });
  pairs_ = node_.subscribe<msgs::StereoPair>("/camera/stereo", graph::QoS::latest(),
                                             [this](const graph::Received<msgs::StereoPair>& pair) {
                                               const std::lock_guard lock(mutex_);
                                               pair_ = *pair;
                                               came_.notify_all();
                                             });
  follow_ = node_.action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                msgs::FollowTrajectoryResult>("/arm/follow");
  node_.spin_in_background();
}

void ArmAndCamera::take(const msgs::JointState& state) {
  if (state.name_size() != state.position_size()) return;
  Joints joints;
  joints.stamp = state.header().stamp();
  joints.names.assign(state.name().begin(), state.name().end());
  joints.positions.assign(state.position().begin(), state.position().end());
  joints.q.resize(chain_.size());
  std::string lacking;
  for (int j = 0; j < chain_.size(); ++j) {
    const std::string& name = chain_.joints()[static_cast<std::size_t>(j)].name;
    const auto found = std::find(joints.names.begin(), joints.names.end(), name);
    if (found == joints.names.end()) {
      lacking = fmt::format("'{}'{}", name, text::nearest_match_hint(name, joints.names));
      break;
    }
    joints.q[j] = joints.positions[static_cast<std::size_t>(found - joints.names.begin())];
  }
  const std::lock_guard lock(mutex_);
  lacking_ = lacking;
  // Several publish on one topic: who has a hand alone says nothing of the arm.
  if (!lacking.empty() || !joints.q.allFinite()) return;
  if (!states_.empty() && joints.stamp < states_.back().stamp) states_.clear();  // a clock set back
  states_.push_back(std::move(joints));
  if (states_.size() > kMostStates) states_.pop_front();
  came_.notify_all();
}

template <class Ready>
void ArmAndCamera::wait_for(std::unique_lock<std::mutex>& lock, const std::string& what,
                            Ready ready) {
  const auto end = steady_clock::now() + std::chrono::duration<double>(patience_);
  while (!ready()) {
    if (interrupted) throw std::runtime_error("interrupted");
    if (steady_clock::now() > end) {
      throw std::runtime_error(fmt::format(
          "{} within {:.0f} s. Start who publishes it (`prehend topic list`){}", what, patience_,
          states_.empty() && !lacking_.empty() ? "; /joint_states has no " + lacking_ : ""));
    }
    came_.wait_for(lock, kTurn);
  }
}

geometry::PinholeCamera ArmAndCamera::camera() {
  std::unique_lock lock(mutex_);
  wait_for(lock, "/camera/info did not come", [&] { return info_.has_value(); });
  return convert::from_message(*info_).left;
}

ArmAndCamera::Joints ArmAndCamera::joints() {
  std::unique_lock lock(mutex_);
  const std::int64_t before = states_.empty() ? 0 : states_.back().stamp;
  wait_for(lock, "/joint_states with the arm's joints did not come",
           [&] { return !states_.empty() && states_.back().stamp != before; });
  return states_.back();
}

void ArmAndCamera::follow(const motion::Trajectory& trajectory) {
  if (!follow_.wait_for_server(std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(patience_)))) {
    throw std::runtime_error(
        "nobody serves /arm/follow. Start the arm's driver or the simulation (`prehend node "
        "list`)");
  }
  const auto handle = follow_.send(arm_goal(chain_, trajectory));
  while (true) {
    const auto outcome = handle.wait(kTurn);
    if (outcome.status() == graph::Status::kTimeout) {
      if (interrupted) {
        handle.cancel();
        handle.wait(std::chrono::seconds(5));  // until it has braked
        throw std::runtime_error("interrupted: the arm was stopped");
      }
      continue;
    }
    if (!outcome.ok()) throw std::runtime_error(outcome.error());
    if (outcome->reached()) return;
    throw std::runtime_error("/arm/follow: " + (outcome->reason().empty()
                                                    ? "the end was not reached"
                                                    : outcome->reason()));
  }
}

ArmAndCamera::Still ArmAndCamera::still_image() {
  std::unique_lock lock(mutex_);
  const std::int64_t before = states_.empty() ? 0 : states_.back().stamp;
  // From when on all states until `last` are where the last one is.
  const auto rest_since = [&]() -> std::int64_t {
    std::int64_t since = states_.back().stamp;
    for (auto state = states_.rbegin(); state != states_.rend(); ++state) {
      if ((state->q - states_.back().q).cwiseAbs().maxCoeff() > kStill) break;
      since = state->stamp;
    }
    return since;
  };
  wait_for(lock, "/joint_states of an arm that stands did not come", [&] {
    return !states_.empty() && states_.back().stamp > before &&
           states_.back().stamp - rest_since() >= kRest;
  });
  const std::int64_t rest = rest_since() + kRest;
  wait_for(lock, "/camera/stereo with an image of the arm at rest did not come", [&] {
    return pair_ && pair_->header().stamp() >= rest &&
           states_.back().stamp >= pair_->header().stamp();
  });
  if (rest_since() + kRest > pair_->header().stamp()) {
    throw std::runtime_error(
        "the arm moved while the image was taken. Stop whoever else commands it");
  }
  Still still;
  still.image = convert::from_message(*pair_).left;
  still.q = states_.back().q;
  return still;
}

}  // namespace prehend::tools
