#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "drivers/sdh/driver/driver.h"
#include "drivers/sdh/emulator/hand.h"
#include "drivers/wire/faults/faulty_line.h"

namespace prehend::drivers::sdh {

/// Driver and emulated hand in simulated time, blocks of bytes passing through lines that can fail.
class VirtualHand {
 public:
  using Block = std::vector<std::uint8_t>;

  explicit VirtualHand(const DriverOptions& options = {}, HandOptions of_hand = {})
      : hand(with_plant(of_hand),
             [this](Bytes bytes) {
               from_hand.push({bytes.begin(), bytes.end()}, now);
             }),
        options_(options),
        driver(make_driver()) {}

  /// The driver's process ends without a word, and another one begins.
  void begin_driver_anew() {
    driver = make_driver();
    driver.connected(now);
  }
  /// Runs for so many seconds, in steps of 2 ms.
  void run(double seconds) {
    constexpr Time kStep = std::chrono::milliseconds(2);
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
      run(0.002);
    }
    return true;
  }
  bool connect() {
    driver.connected(now);
    return run_until([this] { return driver.reading().state > DriverState::kFault; }, 5);
  }
  bool has_problem(const std::string& part) const { return holds(problems, part); }
  bool has_note(const std::string& part) const { return holds(notes, part); }
  /// Something that the hand did not say itself.
  void hear(const std::string& text) {
    driver.receive({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, now);
  }
  /// All axes there at this speed [rad/s] and current [A].
  static HandGoal goal(const AxisValues& position, double speed = 0.7, double current = 0.5) {
    HandGoal goal;
    goal.moves.fill(true);
    goal.position = position;
    goal.speed.fill(speed);
    goal.current.fill(current);
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
  static void harm(Block& block, std::mt19937_64& random) {
    if (block.empty()) return;
    if (random() % 2 == 0) {
      block.resize(random() % block.size());  // cut off
      return;
    }
    block[random() % block.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
  }

  Time now = std::chrono::seconds(100);
  SimpleHand plant;
  FaultyLine<Block> to_hand{&harm, 1}, from_hand{&harm, 2};
  Hand hand;
  std::vector<Block> sent;
  std::function<void(Block&)> tamper;  // with what is sent to the hand, when there is one
  std::vector<std::string> problems, notes;

 private:
  DriverOptions options_;

 public:
  Driver driver;
  bool is_cut = false;
  // What the emulated hand ever did.
  AxisValues fastest{};        // rad/s
  AxisValues least{}, most{};  // rad
  AxisValues strongest{};      // A

 private:
  Driver make_driver() {
    return {options_,
            [this](Bytes bytes) -> std::string {
              sent.emplace_back(bytes.begin(), bytes.end());
              if (is_cut) return "cut";
              Block block = sent.back();
              if (tamper) tamper(block);
              to_hand.push(block, now);
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
    while (const auto block = to_hand.pop(now)) hand.receive(*block, now);
    hand.update(now);
    while (const auto block = from_hand.pop(now)) {
      if (!is_cut) driver.receive(*block, now);
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

}  // namespace prehend::drivers::sdh
