#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "drivers/pg70/driver/driver.h"
#include "drivers/pg70/emulator/module.h"
#include "drivers/wire/faults/faulty_line.h"

namespace prehend::drivers::pg70 {

/// Driver and emulated module in simulated time, messages passing through lines that can fail.
class VirtualGripper {
 public:
  explicit VirtualGripper(const DriverOptions& options = {}, const ModuleOptions& of_module = {})
      : module(plant, of_module,
               [this](Direction direction, const Content& content) {
                 from_module.push({direction, content}, now);
               }),
        driver(
            options,
            [this](const Content& content) -> std::string {
              if (is_cut) return "cut";
              sent.push_back(content);
              if (swallowed.contains(static_cast<Command>(content.command()))) return {};
              to_module.push({Direction::kCommand, content}, now);
              return {};
            },
            [this](bool is_problem, const std::string& words) {
              (is_problem ? problems : notes).push_back(words);
            }) {}

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
  /// Something that the module did not say itself.
  void hear(const Response& response) {
    driver.receive({direction_of(response), encode(response)}, now);
  }
  static void flip_a_bit(Incoming& message, std::mt19937_64& random) {
    std::vector<std::uint8_t> bytes(message.content.bytes().begin(), message.content.bytes().end());
    bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1 << random() % 8);
    message.content = Content(bytes);
  }

  Time now = std::chrono::seconds(100);
  SimpleGripper plant;
  FaultyLine<Incoming> to_module{&flip_a_bit, 1}, from_module{&flip_a_bit, 2};
  Module module;
  std::vector<Content> sent;
  std::vector<std::string> problems, notes;
  Driver driver;
  bool is_cut = false;
  std::set<Command> swallowed;  // that never reach the module
  double fastest = 0;           // m/s, that the jaws ever moved
  double least = 1, most = 0;   // m, opening

 private:
  static bool holds(const std::vector<std::string>& texts, const std::string& part) {
    for (const std::string& words : texts) {
      if (words.find(part) != std::string::npos) return true;
    }
    return false;
  }
  void step() {
    while (const auto message = to_module.pop(now)) module.receive(message->content, now);
    module.update(now);
    while (const auto message = from_module.pop(now)) {
      if (!is_cut) driver.receive(*message, now);
    }
    driver.update(now);
    fastest = std::max(fastest, std::abs(module.motion().velocity));
    least = std::min(least, module.motion().opening);
    most = std::max(most, module.motion().opening);
  }
};

}  // namespace prehend::drivers::pg70
