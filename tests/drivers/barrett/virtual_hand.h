#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/barrett/driver/driver.h"
#include "drivers/barrett/emulator/hand.h"
#include "drivers/wire/faults/faulty_line.h"

namespace prehend::drivers::barrett {

/// Driver and emulated hand in simulated time, frames passing through buses that can fail.
class VirtualHand {
 public:
  explicit VirtualHand(const DriverOptions& options = {}, HandOptions of_hand = {})
      : hand(with_plant(of_hand), [this](const CanFrame& frame) { from_hand.push(frame, now); }),
        options_(options),
        driver(make_driver()) {}

  /// The driver's process ends without a word, and another one begins.
  void begin_driver_anew() {
    driver = make_driver();
    driver.connected(now);
  }
  /// Runs for so many seconds, in steps of 1 ms.
  void run(double seconds) {
    constexpr Time kStep = std::chrono::milliseconds(1);
    const Time end = now + to_time(seconds);
    while (now < end) {
      now += kStep;
      step();
    }
  }
  /// Runs until it holds; false after `seconds`.
  bool run_until(const std::function<bool()>& condition, double seconds = 10) {
    const Time end = now + to_time(seconds);
    while (!condition()) {
      if (now >= end) return false;
      run(0.001);
    }
    return true;
  }
  bool connect() {
    driver.connected(now);
    return run_until([this] { return driver.reading().state >= DriverState::kUninitialised; }, 5);
  }
  /// Connects, and initialises.
  bool begin() {
    if (!connect()) return false;
    std::uint64_t ticket = 0;
    if (!driver.initialise(now, ticket).empty()) return false;
    return run_until([&] { return driver.reading().state == DriverState::kStanding; }, 20);
  }
  bool has_problem(const std::string& part) const { return holds(problems, part); }
  bool has_note(const std::string& part) const { return holds(notes, part); }
  /// All axes there at this speed [rad/s] and torque [MT].
  static HandGoal goal(const AxisValues& position, double speed = 1, double torque = 1000) {
    HandGoal goal;
    goal.moves.fill(true);
    goal.position = position;
    goal.speed.fill(speed);
    goal.current.fill(torque);
    return goal;
  }
  /// Sends and waits for the end.
  MotionReport move(const HandGoal& wanted, double seconds = 20) {
    std::uint64_t ticket = 0;
    const std::string refusal = driver.move_to(wanted, now, ticket);
    if (!refusal.empty()) return {MotionReport::Kind::kFailed, refusal};
    run_until([&] { return driver.report(ticket).kind != MotionReport::Kind::kRunning; }, seconds);
    return driver.report(ticket);
  }
  static void harm(CanFrame& frame, std::mt19937_64& random) {
    if (frame.size == 0) return;
    frame.data[random() % frame.size] ^= static_cast<std::uint8_t>(1 << random() % 8);
  }
  /// Orders that were sent to set `property`, of axis 0 alone.
  int orders(Property property, std::int32_t value) const {
    return static_cast<int>(std::ranges::count_if(sent, [&](const CanFrame& frame) {
      return decode_request(frame) ==
             Request{0, static_cast<std::uint8_t>(property), std::optional(value)};
    }));
  }

  Time now = std::chrono::seconds(100);
  ClutchHand plant;
  FaultyLine<CanFrame> to_hand{&harm, 1}, from_hand{&harm, 2};
  Hand hand;
  std::vector<CanFrame> sent;
  std::vector<std::string> problems, notes;
  std::vector<std::pair<std::size_t, Cells>> images;

 private:
  DriverOptions options_;

 public:
  Driver driver;
  bool is_cut = false;
  // What the emulated hand ever did.
  AxisValues fastest{};        // rad/s
  AxisValues least{}, most{};  // rad
  AxisValues strongest{};      // MT

 private:
  Driver make_driver() {
    return {options_,
            [this](const CanFrame& frame) -> std::string {
              sent.push_back(frame);
              if (is_cut) return "cut";
              to_hand.push(frame, now);
              return {};
            },
            [this](bool is_problem, const std::string& words) {
              (is_problem ? problems : notes).push_back(words);
            },
            [this](std::size_t axis, const Cells& cells) { images.emplace_back(axis, cells); }};
  }
  HandOptions with_plant(HandOptions options) {
    options.plant = &plant;
    return options;
  }
  static bool holds(const std::vector<std::string>& texts, const std::string& part) {
    return std::ranges::any_of(
        texts, [&](const std::string& words) { return words.find(part) != std::string::npos; });
  }
  void step() {
    while (const auto frame = to_hand.pop(now)) hand.receive(*frame, now);
    hand.update(now);
    while (const auto frame = from_hand.pop(now)) {
      if (!is_cut) driver.receive(*frame, now);
    }
    driver.update(now);
    const HandPlant::Motion& motion = hand.motion();
    for (std::size_t i = 0; i < kAxes; ++i) {
      fastest[i] = std::max(fastest[i], std::abs(motion.velocity[i]));
      least[i] = std::min(least[i], motion.position[i]);
      most[i] = std::max(most[i], motion.position[i]);
      strongest[i] = std::max(strongest[i], std::abs(motion.current[i]));
    }
  }
};

}  // namespace prehend::drivers::barrett
