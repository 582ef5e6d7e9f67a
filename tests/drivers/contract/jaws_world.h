#pragma once

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <thread>

#include "drivers/pg70/emulator/gripper_plant.h"
#include "drivers/wire/time/time.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// The least world behind an emulated PG70: two jaws and what stands between them, in real time. It
/// costs next to nothing, so that it keeps up where a whole simulation would not.
class JawsWorld {
 public:
  explicit JawsWorld(graph::Node& node)
      : publisher_(
            node.advertise<msgs::GripperState>("/world/gripper/state", graph::QoS::queue(10))),
        commands_(node.subscribe<msgs::GripperCommand>(
            "/world/gripper/command", graph::QoS::queue(20),
            [this](const graph::Received<msgs::GripperCommand>& message) {
              const std::lock_guard lock(mutex_);
              jaws_.command(command_of(*message));
            })),
        thread_([this] { run(); }) {}
  ~JawsWorld() {
    ends_ = true;
    thread_.join();
  }
  JawsWorld(const JawsWorld&) = delete;
  JawsWorld& operator=(const JawsWorld&) = delete;

  void put_object(std::optional<double> width) {
    const std::lock_guard lock(mutex_);
    jaws_.put_object(width);
  }
  /// Its time stands still, as that of a simulation which is held up.
  void hold_up(bool held) { is_held_ = held; }

 private:
  using Gripper = pg70::GripperPlant;

  static Gripper::Command command_of(const msgs::GripperCommand& message) {
    constexpr double kNominal = 2.0;  // A
    Gripper::Command command{
        .value = message.value(),
        .speed = 0.083,
        .acceleration = 0.32,
        .current = message.current_limit() > 0 ? message.current_limit() : kNominal};
    switch (message.mode()) {
      case msgs::GripperCommand::POSITION:
        command.drive = Gripper::Drive::kPosition;
        break;
      case msgs::GripperCommand::VELOCITY:
        command.drive = Gripper::Drive::kVelocity;
        break;
      case msgs::GripperCommand::CURRENT:
        command.drive = Gripper::Drive::kCurrent;
        break;
      default:
        command.drive = Gripper::Drive::kHold;
    }
    return command;
  }

  void run() {
    constexpr auto kSlice = std::chrono::milliseconds(10);
    constexpr double kLongest = 0.05;  // s: what is held up longer stands still meanwhile
    Time last = steady_now();
    while (!ends_) {
      std::this_thread::sleep_for(kSlice);
      const Time now = steady_now();
      const double passed = std::min(to_seconds(now - last), kLongest);
      last = now;
      if (is_held_) continue;
      msgs::GripperState state;
      {
        const std::lock_guard lock(mutex_);
        const Gripper::Motion motion = jaws_.advance(passed);
        state.mutable_header()->set_stamp(to_time(motion.time).count());
        state.set_opening(motion.opening);
        state.set_velocity(motion.velocity);
        state.set_current(motion.current);
      }
      publisher_.publish(state);
    }
  }

  std::mutex mutex_;  // guards jaws_
  pg70::SimpleGripper jaws_;
  graph::Publisher<msgs::GripperState> publisher_;
  graph::Subscription commands_;
  std::atomic<bool> is_held_ = false, ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers
