#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "nodes/simulation/arm_commands.h"
#include "nodes/simulation/paced_loop.h"
#include "prehend/simulation/hand_request.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::nodes {

/// What the sensors of arm and hand show at one instant.
struct RobotReadings {
  std::int64_t stamp = 0;  // ns, simulated
  std::vector<simulation::JointReading> joints;
  simulation::ContactWrench wrench;
  // Of every second slice.
  bool has_frames = false;
  std::vector<simulation::HandPadReading> pads;
  std::vector<simulation::RobotBodyReading> bodies;
};

/// A world with an arm and a hand, and its clock: like SimulatedRobot. Commands may come from any
/// thread; the arm and the hand belong to who asked last, known by a ticket.
class RobotRunner : public CommandedArm {
 public:
  RobotRunner(graph::Node& node, simulation::RobotWorld world, graph::ClockPacer& pacer,
              std::int64_t slice, std::function<void(const RobotReadings&)> on_readings,
              std::function<void(std::int64_t)> on_pace);
  ~RobotRunner() override { stop(); }

  void start() { loop_.start(); }
  void stop() { loop_.stop(); }

  /// Runs `work` on the world between two steps.
  template <class Work>
  auto with_world(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(world_);
  }

  std::uint64_t take_arm() override;
  bool holds_arm(std::uint64_t ticket) override;
  void stop_arm(std::uint64_t ticket) override;
  void follow(const simulation::TrajectoryRequest& request, const std::vector<double>& tolerance,
              double contact_force) override;
  State arm_state() override;
  bool command_arm(const std::vector<std::string>& joints,
                   const std::vector<double>& positions) override;
  /// A motion of the hand; returns a ticket that loss_of_hand() knows until the next one.
  /// `stamp`: see command_hand(). @throws std::invalid_argument as RobotWorld::move_hand().
  std::uint64_t move_hand(const simulation::HandCommand& command, std::int64_t stamp);
  /// A continuous command: joints that still move kWatchdog later are stopped. Like a motion it
  /// takes the hand over from whoever had it, unless `stamp` [ns] is set and not later than that of
  /// the last move_hand: then it came late, is ignored, and false is returned.
  /// @throws std::invalid_argument as check_joints_request() and RobotWorld::command_hand().
  bool command_hand(const simulation::JointsRequest& request, std::int64_t stamp);
  /// Holds where it is; `why` becomes the reason of the motion that it ends.
  void stop_hand(const std::string& why);
  /// Who took the hand from a motion, in words; "" while nobody has.
  std::string loss_of_hand(std::uint64_t ticket);

  void wait_for_slice() override;

 private:
  void slice();  // into readings_
  RobotReadings read() const;

  graph::Node& node_;
  simulation::RobotWorld world_;
  const int steps_;
  std::function<void(const RobotReadings&)> on_readings_;
  RobotReadings readings_;  // of the loop's thread
  std::mutex mutex_;        // guards what follows and world_
  std::condition_variable slice_done_;
  std::uint64_t slices_ = 0, arm_ticket_ = 0, hand_ticket_ = 0;
  std::string hand_taker_;       // who made the ticket, in words for the one before
  std::int64_t hand_stamp_ = 0;  // ns, of the last move_hand
  bool arm_commanded_ = false;   // by command_arm
  double arm_command_time_ = 0;  // s, simulated
  bool hand_commanded_ = false;  // by command_hand
  double command_time_ = 0;      // s, simulated
  PacedLoop loop_;
};

}  // namespace prehend::nodes
