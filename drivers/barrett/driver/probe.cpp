#include "drivers/barrett/driver/probe.h"

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "drivers/barrett/codec/message.h"
#include "drivers/barrett/driver/device.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett {
namespace {

constexpr auto kListening = std::chrono::milliseconds(100);
constexpr int kTries = 2;

using Answers = std::array<std::optional<int>, kAxes>;

/// What the hand says on the bus, and what becomes of that.
class Ear {
 public:
  explicit Ear(CanBus& bus) : bus_(bus) {}

  /// Of each puck what it says of `property` within `patience`; what it has said is not asked
  /// again.
  Answers ask(Property property, std::chrono::nanoseconds patience) {
    Answers answers;
    for (int i = 0; i < kTries && trouble.empty() && !is_whole(answers); ++i) {
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        if (answers[axis]) continue;
        const std::string problem =
            bus_.send(encode(Request{axis, static_cast<std::uint8_t>(property)}));
        if (!problem.empty()) trouble = problem;
      }
      listen(patience, [&](const Reply& reply) {
        const auto* value = std::get_if<Value>(&reply);
        if (value && value->property == static_cast<std::uint8_t>(property)) {
          answers[value->axis] = value->value;
        }
        return is_whole(answers);
      });
    }
    return answers;
  }
  /// Until `take` is true, or `time` is over.
  template <class Take>
  void listen(std::chrono::nanoseconds time, const Take& take) {
    const Time end = steady_now() + time;
    for (Time now = steady_now(); now < end; now = steady_now()) {
      const auto input = bus_.receive(end - now);
      if (!input) return;
      if (const auto* event = std::get_if<CanEvent>(&*input)) {
        trouble = event->words;
        continue;
      }
      const auto reply = decode_reply(std::get<CanFrame>(*input));
      if (reply && take(*reply)) return;
    }
  }
  static bool is_whole(const Answers& answers) {
    return std::ranges::all_of(answers, [](const auto& one) { return one.has_value(); });
  }

  std::string trouble;

 private:
  CanBus& bus_;
};

std::string named(const Answers& answers, bool that_answer) {
  std::string names;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (answers[i].has_value() != that_answer) continue;
    names += (names.empty() ? "" : ", ") + std::string(axis_name(i)) + " (node " +
             std::to_string(kFirstPuck + i) + ")";
  }
  return names;
}

}  // namespace

Probe probe(const std::string& name, unsigned bit_rate, std::chrono::nanoseconds patience) {
  const auto bus = open_hand_bus(name, bit_rate);
  Ear ear(*bus);
  int heard = 0;
  ear.listen(kListening, [&](const Reply&) { return ++heard > 0; });
  if (heard > 0) {
    return {Probe::Result::kWarns,
            "somebody talks with the BarrettHand on " + name + ", so it was not asked",
            "see what this page says of node barrett, or stop what uses the hand"};
  }
  const Answers versions = ear.ask(Property::kVersion, patience);
  const std::string who = "BarrettHand on " + name;
  if (std::ranges::none_of(versions, [](const auto& one) { return one.has_value(); })) {
    Probe silent{Probe::Result::kSilent, "the hand does not answer on " + name,
                 "check its supply (48 V), wiring, termination and the bit rate (1 Mbit/s)"};
    if (!ear.trouble.empty()) silent.what += ": " + ear.trouble;
    return silent;
  }
  if (!Ear::is_whole(versions)) {
    return {Probe::Result::kSilent,
            who + ": " + named(versions, true) + " answer, not " + named(versions, false),
            "check the hand's internal wiring, or who else has these nodes"};
  }
  Probe found{Probe::Result::kAnswers,
              who + " answers: four pucks, firmware " + std::to_string(*versions[0]),
              {}};
  const Answers status = ear.ask(Property::kStatus, patience);
  const bool all_awake = std::ranges::none_of(
      status, [](const auto& one) { return one == static_cast<int>(Status::kMonitor); });
  // In monitor mode they tell little else.
  const Answers heat = all_awake ? ear.ask(Property::kTemperature, patience) : Answers();
  std::optional<int> hottest;
  for (const auto& one : heat) {
    if (one) hottest = std::max(hottest.value_or(*one), *one);
  }
  if (hottest) found.what += ", " + std::to_string(*hottest) + " degree Celsius at most";
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (status[i] == static_cast<int>(Status::kReady)) continue;
    if (status[i] == static_cast<int>(Status::kMonitor)) {
      found.what += std::string("; ") + axis_name(i) + " is in monitor mode, as after power-on";
      continue;
    }
    found.result = Probe::Result::kWarns;
    found.what += std::string("; ") + axis_name(i) +
                  (status[i] ? " shows STAT " + std::to_string(*status[i]) : " tells no STAT");
    found.mend = "switch its supply off and on";
  }
  return found;
}

}  // namespace prehend::drivers::barrett
