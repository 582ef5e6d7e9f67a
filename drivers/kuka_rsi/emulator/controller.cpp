#include "drivers/kuka_rsi/emulator/controller.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace prehend::drivers::kuka_rsi {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSpeedSlack = 1.001;    // decimals of the wire
constexpr double kPositionSlack = 1e-5;  // rad

Axes to_degrees(const Axes& radians) {
  Axes degrees{};
  for (std::size_t i = 0; i < kAxes; ++i) degrees[i] = radians[i] / kDegree;
  return degrees;
}

}  // namespace

Controller::Controller(ArmPlant& plant, const ControllerOptions& options)
    : plant_(plant), options_(options), ipoc_(Ipoc::of(options.first_ipoc)) {
  actual_ = set_point_ = program_ = plant_.advance(0);
}

void Controller::begin() {
  state_ = State::kRunning;
  why_.clear();
  actual_ = plant_.advance(0);
  program_ = set_point_ = actual_;
  correction_ = {};
  delay_ = 0;
  late_in_row_ = 0;
  awaits_ = is_answered_ = false;
  is_first_ = true;
}

void Controller::end(const std::string& why) {
  if (state_ != State::kRunning) return;
  state_ = State::kStopped;
  why_ = why;
  plant_.command(set_point_);
}

std::string_view Controller::tick(Time now) {
  if (state_ != State::kRunning) {
    actual_ = plant_.advance(options_.cycle);
    return {};
  }
  if (awaits_) take_answer();
  if (state_ == State::kRunning) move();
  actual_ = plant_.advance(options_.cycle);
  if (state_ != State::kRunning) return {};
  ipoc_ = Ipoc::of(ipoc_.value + options_.ipoc_step);
  ++telegrams_;
  is_answered_ = false;
  sent_ = now;
  if (is_first_ && options_.short_first) {
    is_first_ = false;
    constexpr std::string_view kShort = "<Rob Type=\"KUKA\"></Rob>";
    std::copy(kShort.begin(), kShort.end(), out_.begin());
    return {out_.data(), kShort.size()};
  }
  is_first_ = false;
  awaits_ = true;
  RobotTelegram telegram;
  telegram.actual_axes = to_degrees(actual_);
  if (options_.sends_program) telegram.commanded_axes = to_degrees(program_);
  telegram.delay = delay_;
  telegram.ipoc = ipoc_;
  return {out_.data(), write_robot_telegram(out_, options_.names, telegram, options_.layout)};
}

void Controller::take_answer() {
  if (is_answered_) {
    correction_ = answer_;
    late_in_row_ = 0;
    return;
  }
  ++delay_;
  ++late_in_all_;
  ++late_in_row_;
  if (!options_.holds) correction_ = {};
  const auto late = options_.counts_total ? delay_ : static_cast<std::uint64_t>(late_in_row_);
  if (late >= static_cast<std::uint64_t>(options_.late_limit)) {
    end("RSI execution error: " + std::to_string(late) + " answers are missing; RSI stopped");
  }
}

void Controller::move() {
  Axes next{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const std::string axis = "A" + std::to_string(i + 1);
    double correction = correction_[i];
    if (std::abs(correction) > options_.largest_correction) {
      return end("overall correction exceeded at " + axis);
    }
    if (options_.clamp > 0) correction = std::clamp(correction, -options_.clamp, options_.clamp);
    next[i] = program_[i] + correction * kDegree;
    if (next[i] < options_.lower[i] - kPositionSlack ||
        next[i] > options_.upper[i] + kPositionSlack) {
      return end("software limit switch of " + axis);
    }
    const double step = std::abs(next[i] - set_point_[i]) / (options_.speed[i] * options_.cycle);
    largest_step_ = std::max(largest_step_, step);
    if (step > kSpeedSlack) return end("axis speed exceeded at " + axis);
  }
  set_point_ = next;
  plant_.command(set_point_);
}

void Controller::receive(std::string_view text, Time arrived) {
  if (state_ != State::kRunning || !awaits_ || is_answered_) return;
  SensorTelegram answer;
  const char* why = "";
  if (read_sensor_telegram(text, options_.names, answer, why) != TelegramResult::kGood) return;
  const bool is_right = answer.type == options_.names.type && answer.ipoc.text() == ipoc_.text() &&
                        arrived - sent_ <= to_time(options_.answer_time);
  if (!is_right) return;
  if (answer.message.starts_with("Error:")) return end("EStr: " + std::string(answer.message));
  is_answered_ = true;
  answer_ = answer.correction.value_or(options_.holds ? correction_ : Axes{});
}

}  // namespace prehend::drivers::kuka_rsi
