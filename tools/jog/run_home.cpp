#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>

#include "prehend/control/jog_space.h"
#include "prehend/motion/blended_trajectory.h"
#include "prehend/motion/plan_path.h"
#include "prehend/motion/planner_registry.h"
#include "tools/arm_goal.h"
#include "tools/jog/platform_link.h"
#include "tools/jog/runs.h"

namespace prehend::tools {
namespace {

using namespace std::chrono_literals;
using robot::Positions;

constexpr double kThere = 1e-3;       // rad or m
constexpr double kHandThere = 0.01;   // rad or m
constexpr double kPlanningTime = 10;  // s

// Ends in words what `handle` does; the first Ctrl-C cancels it.
void await_hand(RobotLink& link) {
  bool cancelled = false;
  while (true) {
    if (const auto end = link.hand_end()) {
      if (cancelled) throw std::runtime_error("interrupted: the hand was stopped");
      if (end->reached) return;
      throw std::runtime_error(fmt::format(
          "the hand did not open: {}. Give --keep-hand to leave it as it is",
          end->reason.empty() ? (end->blocked ? "blocked" : "it stopped") : end->reason));
    }
    if (interrupted() && !cancelled) {
      link.cancel_hand();
      cancelled = true;
    }
    std::this_thread::sleep_for(10ms);
  }
}

void open_hand(const PlatformLink& robot, const RobotLink::Joints& joints,
               const JogChoices& choices) {
  RobotLink& link = *robot.link;
  if (const std::string holds = holds_text(link, joints); !holds.empty()) {
    std::printf("the hand holds something (%s) and is kept as it is\n", holds.c_str());
    return;
  }
  const RobotLink::HandGoal goal = open_goal(link, joints, "", choices.speed);
  const robot::HandModel& hand = robot.platform.hand;
  const Eigen::VectorXd opened = hand.all_positions(goal.positions);
  const Eigen::VectorXd now = link.hand_positions(joints);
  if ((opened - now).cwiseAbs().maxCoeff() < kHandThere) return;
  control::JogSurroundings around;
  around.table = table_height(choices.table);
  around.clearance = choices.clearance;
  const auto space = control::jog_space(robot.platform, opened, around);
  if (const std::string problem = space->problem(joints.arm);
      !problem.empty() && space_of(robot, joints, choices)->problem(joints.arm).empty()) {
    throw std::runtime_error("opened here, the hand would touch: " + problem +
                             ". Give --keep-hand, or move the arm away by `prehend jog`");
  }
  if (!link.hand_is_served(choices.patience)) {
    throw std::runtime_error(fmt::format(
        "nobody serves {}: the hand cannot be opened. Give --keep-hand to leave it as it is",
        link.hand_action()));
  }
  std::printf("the hand opens\n");
  std::fflush(stdout);
  link.move_hand(goal);
  await_hand(link);
}

Positions within_limits(const robot::KinematicChain& chain, Positions q) {
  for (int j = 0; j < chain.size(); ++j) {
    const robot::ChainJoint& joint = chain.joints()[static_cast<std::size_t>(j)];
    // What an encoder's last digit is beyond.
    constexpr double kBeyond = 1e-3;
    if (q[j] < joint.lower && q[j] > joint.lower - kBeyond) q[j] = joint.lower;
    if (q[j] > joint.upper && q[j] < joint.upper + kBeyond) q[j] = joint.upper;
  }
  return q;
}

motion::BlendedTrajectory plan_home(const PlatformLink& robot, const motion::RobotInWorld& space,
                                    const Positions& start, const Positions& home,
                                    const JogChoices& choices) {
  if (const std::string problem = space.problem(start); !problem.empty()) {
    throw std::runtime_error("where it stands, " + problem +
                             ". Move it free by `prehend jog`, or say what is there by --table");
  }
  if (const std::string problem = space.problem(home); !problem.empty()) {
    throw std::runtime_error(
        fmt::format("at the home '{}', {}. See --table and --clearance", choices.home, problem));
  }
  const auto planner = motion::PlannerRegistry().create(motion::kDefaultPlanner);
  motion::PathOptions options;
  options.budget = kPlanningTime;
  const motion::JointPath path = motion::plan_path(*planner, space, start, {home}, options);
  if (!path.found()) {
    throw std::runtime_error(
        fmt::format("no way to the home '{}' was found: {}", choices.home, path.reason));
  }
  motion::TimingOptions timing;
  timing.speed_factor = choices.speed;
  return motion::blend_trajectory(space, path.waypoints, robot.platform.acceleration, timing);
}

// One line that is written over in a terminal, else one for each quarter.
class Percent {
 public:
  void say(double share) {
    const int percent = std::clamp(static_cast<int>(100 * share), 0, 100);
    if (percent == said_ || (!is_terminal_ && percent / 25 == said_ / 25)) return;
    said_ = percent;
    std::printf(is_terminal_ ? "\r%3d %%" : "%d %%\n", percent);
    std::fflush(stdout);
  }
  void end() const {
    if (is_terminal_) std::printf("\r     \r");
  }

 private:
  const bool is_terminal_ = ::isatty(STDOUT_FILENO) == 1;
  int said_ = -100;
};

void follow(RobotLink& link, const robot::KinematicChain& chain,
            const motion::BlendedTrajectory& trajectory) {
  std::atomic<double> share = 0;
  const auto handle = link.follow().send(
      arm_goal(chain, trajectory), [&](const msgs::FollowTrajectoryFeedback& feedback) {
        share = feedback.time() / std::max(1e-9, trajectory.duration());
      });
  Percent percent;
  while (true) {
    const auto outcome = handle.wait(50ms);
    if (outcome.status() == graph::Status::kTimeout) {
      percent.say(share);
      if (!interrupted()) continue;
      handle.cancel();
      handle.wait(5s);  // until it has braked
      percent.end();
      throw std::runtime_error("interrupted: the arm was stopped");
    }
    percent.end();
    // After this no feedback comes, which writes to `share`.
    handle.cancel();
    if (outcome.ok() && outcome->reached()) return;
    throw std::runtime_error("/arm/follow: " + (!outcome.ok() ? outcome.error()
                                                : outcome->reason().empty()
                                                    ? "the end was not reached"
                                                    : outcome->reason()));
  }
}

}  // namespace

int run_home(const JogChoices& choices) {
  notice_interrupts();
  const PlatformLink robot = link_platform("home", choices);
  RobotLink& link = *robot.link;
  const Positions home = robot.platform.home(choices.home).arm;
  std::printf("robot %s (%s)\n", robot.platform.name.c_str(), robot.found.said_by.c_str());
  RobotLink::Joints joints = link.wait_for_joints(
      choices.patience, choices.keep_hand ? RobotLink::Needed::kArm : RobotLink::Needed::kBoth);
  if (const std::string why = link.forbidden(); !why.empty()) throw std::runtime_error(why);
  if (!link.follow().wait_for_server(std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(choices.patience)))) {
    throw std::runtime_error(
        "nobody serves /arm/follow. Start the arm's driver or the simulation (`prehend node "
        "list`)");
  }
  if (!choices.keep_hand) {
    open_hand(robot, joints, choices);
    joints = link.wait_for_joints(choices.patience, RobotLink::Needed::kBoth);
  }
  const robot::KinematicChain chain = robot.platform.arm_chain();
  const Positions start = within_limits(chain, joints.arm);
  if ((start - home).cwiseAbs().maxCoeff() < kThere) {
    std::printf("the arm is at '%s'\n", choices.home.c_str());
    return 0;
  }
  const auto space = space_of(robot, joints, choices);
  const motion::BlendedTrajectory trajectory = plan_home(robot, *space, start, home, choices);
  if (interrupted()) throw std::runtime_error("interrupted");
  std::printf("the arm moves to '%s' in %.1f s; Ctrl-C stops it\n", choices.home.c_str(),
              trajectory.duration());
  std::fflush(stdout);
  follow(link, chain, trajectory);
  std::printf("the arm is at '%s'\n", choices.home.c_str());
  return 0;
}

}  // namespace prehend::tools
