#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/barrett/driver/gcl/driver.h"
#include "drivers/barrett/emulator/gcl/hand.h"
#include "drivers/wire/faults/faulty_line.h"

namespace prehend::drivers::barrett::gcl {

inline constexpr AxisValues kThere{0.6, 0.5, 0.4, 0.3};  // rad, within every range

/// Driver and emulated BH8-262 in simulated time, bytes passing through lines that can fail.
class VirtualHand {
 public:
  using Block = std::vector<std::uint8_t>;

  explicit VirtualHand(const DriverOptions& options = {}, HandOptions of_hand = {})
      : hand(with_plant(of_hand),
             [this](Bytes bytes) {
               from_hand.push({bytes.begin(), bytes.end()}, now);
             }),
        options_(options),
        driver(make_driver()) {
    run(of_hand.boot_time + 0.3);  // the banner is gone when a driver comes
  }

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
  bool is_in(DriverState state, double seconds = 10) {
    return run_until([&] { return driver.reading().state == state; }, seconds);
  }
  bool connect() {
    driver.connected(now);
    return run_until([this] { return driver.reading().state >= DriverState::kUninitialised; });
  }
  /// Until it stands, and its answers show it.
  bool settles(double seconds = 10) {
    return run_until(
        [&] { return driver.is_settled() && driver.reading().state > DriverState::kFault; },
        seconds);
  }
  /// Connects, and initialises.
  bool begin() {
    if (!connect()) return false;
    if (!driver.initialise(now, ticket).empty()) return false;
    return is_in(DriverState::kStanding, 25);
  }
  bool has_problem(const std::string& part) const { return holds(problems, part); }
  bool has_note(const std::string& part) const { return holds(notes, part); }
  /// All axes there at this speed [rad/s] and motor command.
  static HandGoal goal(const AxisValues& position, double speed = 1, double command = 100) {
    HandGoal goal;
    goal.moves.fill(true);
    goal.position = position;
    goal.speed.fill(speed);
    goal.current.fill(command);
    return goal;
  }
  /// Sends it; "" or why it was refused.
  std::string send(const HandGoal& wanted) { return driver.move_to(wanted, now, ticket); }
  MotionReport::Kind kind() const { return driver.report(ticket).kind; }
  /// Sends and waits for the end.
  MotionReport move(const HandGoal& wanted, double seconds = 20) {
    const std::string refusal = send(wanted);
    if (!refusal.empty()) return {MotionReport::Kind::kFailed, refusal};
    run_until([&] { return kind() != MotionReport::Kind::kRunning; }, seconds);
    return driver.report(ticket);
  }
  /// Begins a slow motion, and waits until it is under way.
  bool begin_to_move(double speed = 0.3) {
    const double from = hand.motion().position[0];
    if (!send(goal({2, 2, 2, 1}, speed)).empty()) return false;
    return run_until([&] { return hand.motion().position[0] > from + 0.1; });
  }
  static void harm(Block& block, std::mt19937_64& random) {
    if (!block.empty())
      block[random() % block.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
  }
  /// Lines that were sent and begin so.
  int lines(const std::string& beginning) const {
    return static_cast<int>(std::ranges::count_if(
        sent, [&](const std::string& one) { return one.starts_with(beginning); }));
  }

  Time now = std::chrono::seconds(100);
  ClutchHand plant;
  FaultyLine<Block> to_hand{&harm, 1}, from_hand{&harm, 2};
  Hand hand;
  std::vector<std::string> sent;
  std::vector<std::string> problems, notes;
  std::uint64_t ticket = 0;

 private:
  DriverOptions options_;

 public:
  Driver driver;
  bool is_cut = false, is_held_up = false;
  // What the emulated hand ever did.
  AxisValues fastest{};        // rad/s
  AxisValues least{}, most{};  // rad
  AxisValues strongest{};      // motor command

 private:
  Driver make_driver() {
    return {options_,
            [this](Bytes bytes) -> std::string {
              sent.emplace_back(bytes.begin(), bytes.end());
              if (is_cut) return "cut";
              to_hand.push({bytes.begin(), bytes.end()}, now);
              return {};
            },
            [this](unsigned baud) -> std::string {
              hand.set_host_baud(baud);
              return {};
            },
            [this](bool is_problem, const std::string& words) {
              (is_problem ? problems : notes).push_back(words);
            }};
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
    while (const auto bytes = to_hand.pop(now)) hand.receive(*bytes, now);
    hand.update(now);
    while (const auto bytes = from_hand.pop(now)) {
      if (!is_cut && !is_held_up) driver.receive(*bytes, now);
    }
    if (!is_held_up) driver.update(now);
    const HandPlant::Motion& motion = hand.motion();
    for (std::size_t i = 0; i < kAxes; ++i) {
      fastest[i] = std::max(fastest[i], std::abs(motion.velocity[i]));
      least[i] = std::min(least[i], motion.position[i]);
      most[i] = std::max(most[i], motion.position[i]);
      strongest[i] = std::max(strongest[i], std::abs(motion.current[i]));
    }
  }
};

}  // namespace prehend::drivers::barrett::gcl
