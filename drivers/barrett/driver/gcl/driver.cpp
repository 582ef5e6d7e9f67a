#include "drivers/barrett/driver/gcl/driver.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr double kBits = 10;              // of a byte on the line
constexpr double kSwitchTime = 1;         // s that a hand may take to change its rate (BHAPI)
constexpr int kMostBaudTries = 2;         // of PSET BAUD
constexpr std::size_t kAnswerSize = 80;   // bytes, about
constexpr std::size_t kMostUnread = 512;  // bytes of which only the end matters

void check(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("BH8-262 driver: ") + what);
}

}  // namespace

Limits bh8_262_limits(const Gearing& gearing) {
  constexpr double kFinger = 140 * M_PI / 180;             // rad
  constexpr double kFingerSpeed = 127, kSpreadSpeed = 60;  // counts per 10 ms
  Limits limits;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool is_spread = i == kSpread;
    limits.upper[i] = is_spread ? M_PI : kFinger;
    limits.max_speed[i] =
        100 * (is_spread ? kSpreadSpeed : kFingerSpeed) / gearing.counts_per_radian(i);
    limits.max_current[i] = kMostCommand;
  }
  return limits;
}

Driver::Driver(const DriverOptions& options, Send send, SetBaud set_baud, Note note)
    : options_(options),
      send_(std::move(send)),
      set_baud_(std::move(set_baud)),
      note_(std::move(note)),
      begins_by_initialising_(options.initialisation == Initialisation::kAtStart),
      baud_(options.baud) {
  for (const double value :
       {options.state_period,       options.watchdog,       options.loss_time,
        options.reply_time,         options.block_time,     options.stop_repeat,
        options.stop_time,          options.quiet_time,     options.stall_time,
        options.tolerance,          options.approach,       options.settle_time,
        options.grip_give,          options.linger,         options.initialise_time,
        options.temperature_period, options.gauge_range,    options.strain_range,
        options.gearing.finger,     options.gearing.spread, options.gearing.counts_per_turn}) {
    check(std::isfinite(value) && value > 0, "times, tolerances and gears must be positive");
  }
  check(options.tries >= 1, "a line needs at least one try");
  check(options.velocity_factor == 1 || options.velocity_factor == 16, "LCV's factor is 1 or 16");
  check(std::isfinite(options.temperature_unit) && options.temperature_unit >= 0,
        "the unit of temperatures must not be negative");
  check(options.initialisation != Initialisation::kDone, "the hand's S tells whether HI was done");
  const auto is_rate = [](unsigned baud) {
    return std::ranges::find(kBauds, baud) != kBauds.end();
  };
  check(is_rate(options.baud) && (options.fast_baud == 0 || is_rate(options.fast_baud)),
        "the hand has no such baud rate");
  check_limits(options.limits);
  gauge_rest_.fill(128);
}

void Driver::connected(Time now) {
  has_line_ = true;
  baud_ = options_.baud;
  begin_connecting(now);
  update_state();
}

void Driver::disconnected(const std::string& why) {
  if (!has_line_) return;
  note_(true, reading_.moving ? why + "; nothing can be sent, so the motion goes on until it stalls"
                              : why);
  has_line_ = lost_ = is_connected_ = false;
  end_motion(why);
  stopping_.reset();
  reading_.blocked.fill(false);
  reading_.moving = false;
  update_state();
}

void Driver::begin_anew(const std::string& why, Time now) {
  if (!has_line_) return;
  note_(true, why);
  begin_connecting(now);
  update_state();
}

// Ctrl-C comes first: whatever the hand was doing, a new connection does not go on with it.
void Driver::begin_connecting(Time now) {
  ++counters_.connections;
  end_motion("the connection began anew");
  stopping_.reset();
  is_connected_ = has_version_ = false;
  reading_.states = 0;
  reading_.moving = false;
  reading_.blocked.fill(false);
  reading_.answers.fill(false);
  steps_.clear();
  samples_.clear();
  turn_ = sync_tries_ = 0;
  last_state_ = last_temperature_ = now;
  select_baud(baud_);  // who has used the line may have changed it
  begin_sync(now, false);
}

void Driver::select_baud(unsigned baud) {
  baud_ = baud;
  const std::string problem = set_baud_(baud);
  if (!problem.empty()) note_(true, problem);
}

double Driver::line_time(std::size_t bytes) const {
  return static_cast<double>(bytes) * kBits / baud_;
}

void Driver::write(std::string_view text) {
  send_({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void Driver::ask(const Step& step, Time now) {
  step_ = step;
  received_.clear();
  mode_ = Mode::kAsking;
  sent_ = last_byte_ = now;
  write(step.line + "\r");
}

void Driver::receive(Bytes bytes, Time now) {
  if (!has_line_ || bytes.empty()) return;
  last_byte_ = now;
  received_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  switch (mode_) {
    case Mode::kSyncing:
    case Mode::kSwitching:
      if (received_.size() > kMostUnread) received_.erase(0, received_.size() - kMostUnread);
      break;
    case Mode::kIdle:  // a banner, or what came late
      ++counters_.strange;
      steps_.push_front({Step::Kind::kStatus, "FGET S"});
      begin_sync(now, false);
      break;
    case Mode::kAsking:
      take_answer(now);
      break;
    case Mode::kInLoop:
      take_block(now);
      break;
  }
  update_state();
}

void Driver::update(Time now) {
  if (!has_line_) return;
  watch_exchange(now);
  watch_loss(now);
  watch_stop(now);
  update_motion(now);
  if (mode_ == Mode::kIdle) next_exchange(now);
  if (mode_ == Mode::kInLoop && !is_block_out_) {
    if (is_loop_wanted(now)) {
      if (now >= next_block_) send_block(now);
    } else {
      leave_loop(now);
    }
  }
  update_state();
}

void Driver::watch_exchange(Time now) {
  const Time waited = now - std::max(sent_, last_byte_);
  switch (mode_) {
    case Mode::kSyncing:
      return watch_sync(now);
    case Mode::kSwitching:
      if (now - sent_ < to_time(kSwitchTime)) return;
      note_(false, "the line's rate is " + std::to_string(baud_) + " now");
      return begin_sync(now, false);
    case Mode::kAsking: {
      const double patience = step_.kind == Step::Kind::kInitialise
                                  ? options_.initialise_time
                                  : options_.reply_time + line_time(kAnswerSize);
      if (waited > to_time(patience)) trouble("no prompt after " + step_.line, now);
      return;
    }
    case Mode::kInLoop: {
      if (!is_block_out_) return;
      const double patience =
          options_.block_time + line_time(layout_.control_size() + 1 + layout_.feedback_size());
      if (now - sent_ > to_time(patience)) {
        ++counters_.unanswered;
        loop_failed("a feedback block is missing, or short", true, now);
      }
      return;
    }
    case Mode::kIdle:
      return;
  }
}

// An exchange that came to harm: the line is made clean, and it is tried again, unless it moves.
void Driver::trouble(const std::string& why, Time now) {
  ++counters_.unanswered;
  Step step = step_;
  if (step.kind == Step::Kind::kLoop) return loop_failed(why, true, now);
  if (step.kind == Step::Kind::kInitialise) {
    note_(true, why);
    return stop(now, why);
  }
  if (step.kind == Step::Kind::kRate) ++baud_tries_;
  const bool again = step.kind != Step::Kind::kRate && step.tries < options_.tries;
  if (again) {
    ++step.tries;
    steps_.push_front(step);
  } else if (step.kind == Step::Kind::kCheck) {
    reading_.problem = "the hand does not keep what it is told: " + step.line + " shows it";
    note_(true, reading_.problem);
    return begin_connecting(now);
  } else if (!is_connected_) {
    return begin_connecting(now);
  }
  // What it says now may be that it was reset.
  if (is_connected_ && step.kind != Step::Kind::kStatus) {
    steps_.push_front({Step::Kind::kStatus, "FGET S"});
  }
  begin_sync(now, false);
}

void Driver::watch_loss(Time now) {
  if (!is_connected_ || motion_.initialises) return;
  if (now - last_state_ <= to_time(options_.loss_time)) return;
  lost_ = true;
  note_(true, "no position from the hand for " + number(options_.loss_time) +
                  " s: Ctrl-C is sent until it is answered");
  end_motion("the hand's answers were lost");
  begin_connecting(now);
}

void Driver::next_exchange(Time now) {
  constexpr double kFaultPeriod = 2;  // s between looks at a hand that cannot be used
  if (steps_.empty() && !is_connected_) {
    if (reading_.problem.empty() || now - last_state_ < to_time(kFaultPeriod)) return;
    return begin_connecting(now);
  }
  const bool loops = is_loop_wanted(now);
  // What RealTime mode tells by itself need not be asked for before.
  if (loops) std::erase_if(steps_, [](const Step& step) { return is_reading(step.kind); });
  if (steps_.empty()) {
    if (loops) {
      return ask({Step::Kind::kLoop, encode(Request{{true, true, true, true}, "LOOP"})}, now);
    }
    if (now < next_cycle_) return;
    add_readings(now);
  }
  // Who follows the joints hears of them between other questions, too.
  constexpr double kOld = 0.06;  // s
  const bool is_old = is_connected_ && now - last_state_ > to_time(kOld);
  const Step::Kind next = steps_.front().kind;
  if (is_old && next != Step::Kind::kPosition && next != Step::Kind::kInitialise) {
    return ask({Step::Kind::kPosition, "FGET P"}, now);
  }
  const Step step = steps_.front();
  steps_.pop_front();
  ask(step, now);
}

bool Driver::is_reading(Step::Kind kind) {
  return kind == Step::Kind::kPosition || kind == Step::Kind::kStrain ||
         kind == Step::Kind::kBreakaway || kind == Step::Kind::kBreakawayAt ||
         kind == Step::Kind::kTemperature;
}

// Names of properties are asked for one by one: in which order several come is not published.
void Driver::add_connection_steps() {
  using Kind = Step::Kind;
  if (!has_version_) {
    const bool speeds_up = options_.fast_baud != 0 && options_.fast_baud != baud_;
    if (speeds_up && baud_tries_ < kMostBaudTries) {
      steps_.push_back({Kind::kRate, "PSET BAUD " + std::to_string(options_.fast_baud / 100)});
    }
    steps_.push_back({Kind::kVersion, "VERS"});
    return;
  }
  steps_.push_back({Kind::kStatus, "FGET S"});
  const std::string factor = std::to_string(options_.velocity_factor);
  steps_.push_back(
      {Kind::kSet, "1234FSET EN 1 LCV 1 LCVC " + factor + " LCPG 1 LFV 0 LFS 1 LFAP 1 LFDP 0"});
  steps_.push_back({Kind::kSet, "4FSET LFS 0"});
  struct Property {
    const char* name;
    std::vector<int> values;
  };
  std::vector<Property> properties{
      {"LCV", {1, 1, 1, 1}},  {"LCVC", std::vector<int>(kAxes, options_.velocity_factor)},
      {"LCPG", {1, 1, 1, 1}}, {"LFV", {0, 0, 0, 0}},
      {"LFS", {1, 1, 1, 0}},  {"LFAP", {1, 1, 1, 1}},
      {"LFDP", {0, 0, 0, 0}}};
  if (layout_.firmware == Firmware::k4_4) {
    steps_.push_back({Kind::kSet, "1234FSET LCT 0 LFBP 0 LFAIN 0"});
    for (const char* name : {"LCT", "LFBP", "LFAIN"}) properties.push_back({name, {0, 0, 0, 0}});
  }
  for (const Property& property : properties) {
    steps_.push_back({Kind::kCheck, std::string("FGET ") + property.name, property.values});
  }
  steps_.push_back({Kind::kSet, "PSET LFT 1"});
  steps_.push_back({Kind::kCheck, "PGET LFT", {1}});
  steps_.push_back({Kind::kTemperature, "PGET TEMP"});
  steps_.push_back({Kind::kBreakaway, "FGET BD"});
  steps_.push_back({Kind::kPosition, "FGET P"});
  steps_.push_back({Kind::kStrain, "FGET SG"});
}

void Driver::add_readings(Time now) {
  constexpr int kPerStrain = 6, kPerStatus = 12, kPerBreakaway = 12;  // rounds
  next_cycle_ = std::max(next_cycle_ + to_time(options_.state_period), now);
  ++turn_;
  steps_.push_back({Step::Kind::kPosition, "FGET P"});
  if (turn_ % kPerStrain == 1) steps_.push_back({Step::Kind::kStrain, "FGET SG"});
  if (turn_ % kPerStatus == 4) steps_.push_back({Step::Kind::kStatus, "FGET S"});
  if (turn_ % kPerBreakaway == 10) steps_.push_back({Step::Kind::kBreakaway, "FGET BD"});
  if (now - last_temperature_ < to_time(options_.temperature_period)) return;
  last_temperature_ = now;
  steps_.push_back({Step::Kind::kTemperature, "PGET TEMP"});
}

std::string Driver::axis_words(std::size_t axis) const {
  const bool goes = motion_.axes[axis].phase == Phase::kGoing;
  const std::string words = motion_.initialises      ? "initialising"
                            : mode_ != Mode::kInLoop ? "off"
                            : goes                   ? "velocity"
                                                     : "velocity, at rest";
  return words + (reading_.clutch_open[axis] ? ", clutch open" : "");
}

void Driver::update_state() {
  reading_.state = !has_line_                  ? DriverState::kDisconnected
                   : lost_                     ? DriverState::kLost
                   : !reading_.problem.empty() ? DriverState::kFault
                   : !is_connected_            ? DriverState::kConnecting
                   : motion_.initialises       ? DriverState::kInitialising
                   : !is_initialised_          ? DriverState::kUninitialised
                   : reading_.moving           ? DriverState::kMoving
                   : reading_.is_blocked()     ? DriverState::kHolding
                                               : DriverState::kStanding;
}

}  // namespace prehend::drivers::barrett::gcl
