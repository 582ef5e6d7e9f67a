#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/kuka_rsi/driver/driver.h"
#include "drivers/kuka_rsi/emulator/controller.h"
#include "drivers/wire/faults/faulty_line.h"
#include "prehend/robot/platform.h"

namespace prehend::drivers::kuka_rsi {

inline const robot::Platform& kuka() {
  static const robot::Platform platform = robot::read_platform("config/robots/kr5_pg70.yaml");
  return platform;
}

inline Axes home_of_kuka() {
  Axes home{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    home[i] = kuka().home("home").arm[static_cast<Eigen::Index>(i)];
  }
  return home;
}

inline Limits::Options wide_limits() {
  Limits::Options options;
  options.largest_correction = 6;
  options.X_WB = kuka().X_WB;
  return options;
}

inline Limits limits_of_kuka(const Limits::Options& options = wide_limits()) {
  return {kuka().arm_chain(), options};
}

inline ControllerOptions controller_of_kuka() {
  ControllerOptions options;
  const robot::KinematicChain chain = kuka().arm_chain();
  for (std::size_t i = 0; i < kAxes; ++i) {
    options.lower[i] = chain.joints()[i].lower;
    options.upper[i] = chain.joints()[i].upper;
    options.speed[i] = chain.joints()[i].max_velocity;
  }
  options.largest_correction = 350;
  return options;
}

/// From `from` to `to` in `duration` [s], s(t) = 10 t^3 - 15 t^4 + 6 t^5 in between.
inline simulation::ArmTrajectory way(const Axes& from, const Axes& to, double duration) {
  simulation::ArmTrajectory trajectory;
  trajectory.has_velocity = trajectory.has_acceleration = true;
  for (const bool is_end : {false, true}) {
    simulation::ArmTrajectory::Point point;
    point.time = is_end ? duration : 0;
    point.position = Eigen::Map<const Eigen::Matrix<double, kAxes, 1>>((is_end ? to : from).data());
    point.velocity.setZero(6);
    point.acceleration.setZero(6);
    trajectory.points.push_back(point);
  }
  return trajectory;
}

/// Driver and controller with a network between them, in made-up time. What the arm does is watched
/// at the arm.
class VirtualRobot {
 public:
  explicit VirtualRobot(const DriverOptions& driver_options = {},
                        const ControllerOptions& controller_options = controller_of_kuka(),
                        const Limits::Options& limits = wide_limits(), std::uint64_t seed = 1)
      : driver_options_(driver_options),
        limits_(limits_of_kuka(limits)),
        arm(home_of_kuka()),
        controller(arm, controller_options),
        driver(std::make_unique<Driver>(driver_options, limits_)),
        out(&corrupt, seed),
        in(&corrupt, seed + 1),
        cycle_(to_time(controller_options.cycle)) {}

  /// A cycle of the controller; the driver answers 1 ms after it got something.
  void step() {
    now += cycle_;
    const std::string_view telegram = controller.tick(now);
    watch();
    if (!telegram.empty()) out.push(std::string(telegram), now);
    constexpr int kParts = 6;
    for (int part = 0; part < kParts; ++part) {
      const Time then = now + part * cycle_ / kParts;
      if (driver) {
        driver->on_time(then);
        while (const auto item = out.pop(then)) {
          last_answer = std::string(driver->on_packet(*item, then));
          if (!last_answer.empty()) in.push(last_answer, then + std::chrono::milliseconds(1));
        }
      } else {
        while (out.pop(then)) {
        }
      }
      while (const auto item = in.next_due(then)) controller.receive(item->second, item->first);
    }
  }
  void run(double seconds) {
    const auto count = static_cast<int>(std::lround(seconds / to_seconds(cycle_)));
    for (int i = 0; i < count; ++i) step();
  }
  void begin() {
    controller.begin();
    run(0.2);
  }
  /// Another driver in place of this one, which knows nothing of it.
  void restart_driver() { driver = std::make_unique<Driver>(driver_options_, limits_); }

  bool move(const Axes& to, double duration, double contact_force = 0) {
    const Snapshot& s = driver->snapshot();
    auto motion = std::make_unique<Motion>();
    motion->ticket = s.ticket + 1;
    motion->contact_force = contact_force;
    motion->tolerance.fill(0.2);
    motion->set_points = set_points_of(way(s.set_point, to, duration), s.set_point, s.reference,
                                       limits_, to_seconds(cycle_));
    const Motion* mine = motion.get();
    return driver->start(std::move(motion)).get() != mine;
  }
  const Snapshot& snapshot() const { return driver->snapshot(); }
  const Limits& limits() const { return limits_; }

 private:
  static void corrupt(std::string& text, std::mt19937_64& random) {
    if (text.empty()) return;
    switch (random() % 4) {
      case 0:
        text[random() % text.size()] ^= static_cast<char>(1u << random() % 8);
        break;
      case 1:
        text.resize(random() % text.size());
        break;
      case 2:
        for (char& c : text) c = static_cast<char>(random());
        break;
      default:
        text.erase(random() % text.size(), 1 + random() % 8);
    }
  }
  // Of the arm's own axes, not of what it was told.
  void watch() {
    const Axes& q = arm.actual();
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (had_last_) {
        const double speed = std::abs(q[i] - last_[i]) / to_seconds(cycle_);
        fastest = std::max(fastest, speed / limits_.speed(i));
      }
      beyond = std::max({beyond, limits_.lower(i) - q[i], q[i] - limits_.upper(i)});
    }
    if (!limits_.tool_is_inside(q)) ++outside;
    last_ = q;
    had_last_ = true;
  }

  const DriverOptions driver_options_;
  const Limits limits_;

 public:
  SimpleArm arm;
  Controller controller;
  std::unique_ptr<Driver> driver;  // null: the PC is off
  FaultyLine<std::string> out, in;
  Time now{std::chrono::seconds(1000)};
  std::string last_answer;
  double fastest = 0;    // of any axis, as part of its limit of speed
  double beyond = -1e9;  // rad, of any axis beyond its limit of position
  int outside = 0;       // cycles in which the tool was out of its box

 private:
  const Time cycle_;
  Axes last_{};
  bool had_last_ = false;
};

}  // namespace prehend::drivers::kuka_rsi
