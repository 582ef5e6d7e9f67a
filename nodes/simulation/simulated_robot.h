#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "nodes/simulation/arm_commands.h"
#include "nodes/simulation/paced_loop.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/stage_arm.h"
#include "prehend/simulation/world.h"

namespace prehend::nodes {

/// What the sensors show at one instant.
struct SensorReadings {
  std::int64_t stamp = 0;  // ns, simulated
  simulation::GripperReading gripper;
  std::uint32_t gripper_error = 0;               // as of a PG70
  std::vector<simulation::JointReading> joints;  // of the stage
  simulation::ContactWrench wrench;
  // Of every second slice.
  bool has_frames = false;
  simulation::TactileImage left, right;  // empty when the scene's pads have no texels
  std::vector<simulation::BodyReading> bodies;
};

/// The world of a stage with its clock: a thread steps it in slices of about 10 ms of simulated
/// time, as the pacer allows, and hands out readings after each slice, outside the lock. Commands
/// may come from any thread.
class SimulatedRobot : public CommandedArm {
 public:
  static constexpr double kSlice = 0.01;  // s, simulated

  /// [ns] Length of a slice: the whole steps of the scene nearest to kSlice, at least one.
  static std::int64_t slice_of(const simulation::Scene& scene);

  /// `node` tells what goes wrong. The scene's carrier is that of `platform` at `home`. `pacer`
  /// begins at 0 with slices of slice_of(scene) and must outlive the object. Both functions are
  /// called by the thread: `on_readings` after each slice; `on_pace` with the simulated time [ns]
  /// when the clock was paused, resumed or got another speed.
  SimulatedRobot(graph::Node& node, const simulation::Scene& scene, const robot::Platform& platform,
                 const std::string& home, graph::ClockPacer& pacer,
                 std::function<void(const SensorReadings&)> on_readings,
                 std::function<void(std::int64_t)> on_pace);
  ~SimulatedRobot() override { stop(); }

  void start() { loop_.start(); }
  void stop() { loop_.stop(); }

  /// Runs `work` on the world between two steps.
  template <class Work>
  auto with_world(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(world_);
  }

  /// A continuous command: stopped by the watchdog when the jaws still move kWatchdog later.
  /// Like an action's command it takes the gripper over from whoever had it, unless `stamp` [ns]
  /// is set and not later than that of the last move_gripper: then it came late and is ignored.
  /// @throws std::invalid_argument as World::set_gripper_command, or after a fast stop.
  void command_gripper(simulation::GripperMode mode, double value, double current_limit,
                       std::int64_t stamp);
  /// A command with an own end; returns a ticket that loss_of_gripper() knows until the next one.
  std::uint64_t move_gripper(double opening, double speed, double current_limit,
                             std::int64_t stamp);
  /// Who took the gripper from a motion, in words; "" while nobody has.
  std::string loss_of_gripper(std::uint64_t ticket);
  /// Brakes and holds; `why` becomes the reason of the motion that it ends.
  void stop_gripper(const std::string& why);
  /// Brakes, and refuses every command until acknowledge_gripper().
  void fast_stop_gripper(const std::string& why);
  /// True when there was something to acknowledge.
  bool acknowledge_gripper();

  std::uint64_t take_arm() override;
  bool holds_arm(std::uint64_t ticket) override;
  void stop_arm(std::uint64_t ticket) override;
  void follow(const simulation::TrajectoryRequest& request, const std::vector<double>& tolerance,
              double contact_force) override;
  State arm_state() override;
  bool command_arm(const std::vector<std::string>& joints,
                   const std::vector<double>& positions) override;
  void wait_for_slice() override;

 private:
  void slice();  // into readings_
  void step_slice();
  SensorReadings read() const;
  void check_gripper() const;

  graph::Node& node_;
  simulation::World world_;
  simulation::StageArm arm_;
  std::function<void(const SensorReadings&)> on_readings_;
  SensorReadings readings_;  // of the loop's thread

  std::mutex mutex_;  // guards what follows and world_
  std::condition_variable slice_done_;
  std::uint64_t slices_ = 0;
  std::uint64_t gripper_ticket_ = 0, arm_ticket_ = 0;
  std::string gripper_taker_;  // who made the ticket, in words for the one before
  std::uint32_t gripper_error_ = 0;
  std::int64_t action_stamp_ = 0;  // ns, of the last move_gripper
  bool continuous_command_ = false;
  double command_time_ = 0;      // s, simulated
  bool arm_commanded_ = false;   // by command_arm
  double arm_command_time_ = 0;  // s, simulated
  bool watchdog_fired_ = false;

  PacedLoop loop_;
};

}  // namespace prehend::nodes
