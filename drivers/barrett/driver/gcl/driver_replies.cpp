// What the driver makes of the hand's answers in Supervisory mode.

#include <algorithm>
#include <cmath>

#include "drivers/barrett/driver/gcl/driver.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr int kNoGauge = 255;
constexpr double kGaugeMiddle = 127;  // counts from rest to full scale

}  // namespace

void Driver::take_answer(Time now) {
  const Reply reply = parse_reply(received_, step_.line);
  const Step step = step_;
  switch (reply.kind) {
    case Reply::Kind::kPending:
      // The hand changes its rate behind the echo; its prompt comes at the new one.
      if (step.kind == Step::Kind::kRate && received_.size() > step.line.size() + 1) {
        mode_ = Mode::kSwitching;
        sent_ = now;
        ++baud_tries_;
        select_baud(options_.fast_baud);
      }
      return;
    case Reply::Kind::kDamaged:
      ++counters_.strange;
      return trouble("the echo of " + step.line + " is another", now);
    case Reply::Kind::kLoops:
      if (step.kind != Step::Kind::kLoop) {
        ++counters_.strange;
        return trouble("the echo of " + step.line + " is another", now);
      }
      ++counters_.replies;
      mode_ = Mode::kInLoop;
      is_block_out_ = false;
      next_block_ = now;
      received_.clear();
      return;
    case Reply::Kind::kDone:
      break;
  }
  ++counters_.replies;
  mode_ = Mode::kIdle;
  received_.clear();
  if (reply.error != 0 || step.kind == Step::Kind::kLoop || step.kind == Step::Kind::kRate) {
    return refused(step, reply.error, now);
  }
  if (take(step, reply, now)) return;
  ++counters_.strange;
  trouble("the answer to " + step.line + " is none that can be", now);
}

void Driver::refused(const Step& step, int error, Time now) {
  reading_.error_code = error;
  const std::string words = "the hand refuses " + step.line + ": " + describe_status(error);
  switch (step.kind) {
    case Step::Kind::kLoop:
    case Step::Kind::kInitialise:
      if ((error & kNotInitialised) != 0 && step.kind == Step::Kind::kLoop) return was_reset(now);
      note_(true, words);
      return stop(now, words);
    case Step::Kind::kRate:
      ++baud_tries_;
      return note_(true, words + "; the line stays at " + std::to_string(baud_));
    case Step::Kind::kBreakaway:
    case Step::Kind::kBreakawayAt:
    case Step::Kind::kTemperature:
      return;  // it can do without
    case Step::Kind::kSet:
    case Step::Kind::kCheck:
      if (is_connected_) return;  // BD may be read-only
      reading_.problem = words + ". Is its firmware the one that firmware:= names?";
      steps_.clear();
      return note_(true, reading_.problem);
    default:
      return trouble(words, now);
  }
}

bool Driver::take(const Step& step, const Reply& reply, Time now) {
  const std::vector<int> values =
      reply.lines.size() == 1 ? integers_of(reply.lines.front()) : std::vector<int>();
  const bool is_of_axes = values.size() == kAxes;
  switch (step.kind) {
    case Step::Kind::kVersion: {
      std::string text;
      for (const std::string& line : reply.lines) text += (text.empty() ? "" : " ") + line;
      const auto firmware = options_.firmware ? options_.firmware : firmware_of(text);
      reading_.firmware = text;
      if (!firmware) {
        reading_.problem = "the hand says '" + text +
                           "', which names neither firmware 4.3 nor 4.4: give firmware:= which";
        note_(true, reading_.problem);
        return true;
      }
      layout_ = {};
      layout_.firmware = *firmware;
      layout_.temperature = true;
      for (std::size_t i = 0; i < kAxes; ++i) {
        layout_.motors[i] = {.loops = true,
                             .speed = false,
                             .strain = i != kSpread,
                             .delta = false,
                             .velocity_coefficient = options_.velocity_factor};
      }
      has_version_ = true;
      add_connection_steps();
      return true;
    }
    case Step::Kind::kStatus:
      if (is_of_axes) take_status(values, now);
      return is_of_axes;
    case Step::Kind::kTemperature: {
      constexpr int kColdest = -550, kHottest = 1250;  // 0.1 degree Celsius
      const bool can_be = values.size() == 1 && values[0] >= kColdest && values[0] <= kHottest;
      if (can_be) reading_.temperature = 0.1 * values[0];
      return can_be;
    }
    case Step::Kind::kCheck:
      return values == step.expected;
    case Step::Kind::kPosition: {
      if (!is_of_axes) return false;
      AxisValues counts;
      std::ranges::copy(values, counts.begin());
      const std::uint64_t before = reading_.states;
      take_positions(counts, now);
      return reading_.states != before;
    }
    case Step::Kind::kStrain:
      if (!is_of_axes) return false;
      for (std::size_t i = 0; i < kAxes; ++i) take_strain(i, values[i]);
      if (steps_.empty() && motion_.initialises) {
        conclude_initialising(now);
      } else if (steps_.empty() && !is_connected_) {
        connection_is_made(now);
      }
      return true;
    case Step::Kind::kBreakaway:
      if (!is_of_axes) return false;
      std::ranges::copy(values, breakaway_.begin());
      if (std::ranges::any_of(breakaway_, [](int on) { return on != 0; })) {
        steps_.push_front({Step::Kind::kBreakawayAt, "FGET BP"});
      }
      return true;
    case Step::Kind::kBreakawayAt:
      if (!is_of_axes) return false;
      std::ranges::copy(values, breakaway_at_.begin());
      take_breakaways();
      return true;
    case Step::Kind::kInitialise:
      // It is believed when S, the positions and the gauges show it; a hand that was reset before
      // has lost its layout.
      last_state_ = now;
      samples_.clear();
      add_connection_steps();
      return true;
    default:
      return true;
  }
}

void Driver::take_status(const std::vector<int>& values, Time now) {
  int all = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    all |= values[i];
    if ((values[i] & (kNoBoard | kNoMotor)) == 0) continue;
    reading_.problem = std::string(axis_name(i)) + " of the hand: " + describe_status(values[i]) +
                       ". Switch its supply off and on";
    steps_.clear();
    last_state_ = now;
    note_(true, reading_.problem);
    end_motion(reading_.problem);
    is_connected_ = false;
    return;
  }
  reading_.error_code = all & ~(kNotInitialised | kAborted);
  const bool was = is_initialised_;
  is_initialised_ = (all & kNotInitialised) == 0;
  if (is_connected_ && was && !is_initialised_) return was_reset(now);
  if (motion_.initialises && !is_initialised_) {
    const std::string words = "the hand says that it is not initialised, although HI has ended";
    note_(true, words);
    stop(now, words);
  }
}

void Driver::was_reset(Time now) {
  note_(true, "the hand was reset: it has to be initialised again");
  is_initialised_ = false;
  end_motion("the hand was reset");
  begin_connecting(now);
}

void Driver::conclude_initialising(Time now) {
  constexpr double kZero = 0.1;  // rad: the open stop
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (std::abs(reading_.position[i]) < kZero) continue;
    const std::string words = std::string("after its initialisation ") + axis_name(i) + " is at " +
                              number(reading_.position[i]) + " rad, not at its zero";
    note_(true, words);
    return stop(now, words);
  }
  motion_.initialises = false;
  motion_.ended = true;
  note_(false, "the hand is initialised");
  look_whether_it_moves();
}

void Driver::connection_is_made(Time now) {
  is_connected_ = true;
  lost_ = false;
  reading_.problem.clear();
  last_state_ = next_cycle_ = now;
  note_(false, "the hand answers: " + reading_.firmware + ", " + std::to_string(baud_) + " baud");
}

void Driver::take_positions(const AxisValues& counts, Time now) {
  constexpr double kBeyond = 0.3;     // rad beyond the range: no hand shows that
  constexpr std::size_t kWindow = 6;  // readings, over which a speed is looked at
  Sample sample{.time = now};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Limits& limits = options_.limits;
    const double angle = counts[i] / counts_per_radian(i);
    const bool can_be = !is_initialised_ ||
                        (angle > limits.lower[i] - kBeyond && angle < limits.upper[i] + kBeyond);
    if (!can_be) return;
    sample.motor[i] = angle;
    const double opened = breakaway_at_[i] / counts_per_radian(i);
    const bool is_open = i != kSpread && breakaway_[i] != 0;
    sample.joint[i] = is_open ? std::min(angle, opened) : angle;
    constexpr double kSlack = 0.05;  // rad
    reading_.clutch_open[i] = is_open && angle > opened + kSlack;
  }
  samples_.push_back(sample);
  if (samples_.size() > kWindow) samples_.pop_front();
  reading_.position = sample.motor;
  reading_.joint = sample.joint;
  const Sample& first = samples_.front();
  // Of readings that lie close together their jitter would be most of it.
  constexpr double kLeastSpan = 0.08;  // s
  const double passed = std::max(to_seconds(now - first.time), kLeastSpan);
  for (std::size_t i = 0; i < kAxes; ++i) {
    reading_.velocity[i] = (sample.motor[i] - first.motor[i]) / passed;
    reading_.joint_velocity[i] = (sample.joint[i] - first.joint[i]) / passed;
  }
  reading_.answers.fill(true);
  last_state_ = now;
  ++reading_.states;
  look_whether_it_moves();
}

// An open finger that nothing blocks shows what its gauge has at rest.
void Driver::take_strain(std::size_t axis, int value) {
  constexpr double kOpen = 0.05;  // rad
  if (axis == kSpread) return;
  reading_.gauge_fails[axis] = value == kNoGauge;
  gauge_[axis] = value;
  const bool rests = !reading_.moving || motion_.initialises;
  if (rests && std::abs(reading_.position[axis]) < kOpen && !reading_.blocked[axis]) {
    gauge_rest_[axis] = value;
  }
  reading_.effort[axis] = reading_.gauge_fails[axis]
                              ? 0
                              : (value - gauge_rest_[axis]) / kGaugeMiddle * options_.gauge_range;
}

// The flag stays until O, TO or HI, which are not used here: it is taken back where the finger has
// gone back behind the place. Whether BD can be set is not confirmed; what refuses it is tolerated.
void Driver::take_breakaways() {
  constexpr double kBack = 0.1;  // rad
  for (std::size_t i = 0; i < kSpread; ++i) {
    const double at = breakaway_at_[i] / counts_per_radian(i);
    if (breakaway_[i] == 0 || reading_.position[i] > at - kBack) continue;
    breakaway_[i] = 0;
    Request request{.command = "FSET", .words = {"BD", "0"}};
    request.motors[i] = true;
    if (is_connected_) steps_.push_back({Step::Kind::kSet, encode(request)});
  }
}

}  // namespace prehend::drivers::barrett::gcl
