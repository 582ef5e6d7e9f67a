#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/barrett/driver/driver.h"

namespace prehend::drivers::barrett {
namespace {

constexpr double kGaugeMiddle = 2048;  // counts, about where it rests

}  // namespace

void Driver::take(const Value& value, Time now) {
  Puck& puck = pucks_[value.axis];
  if (!puck.asked || static_cast<std::uint8_t>(puck.asked->property) != value.property) {
    ++counters_.strange;
    return;
  }
  Step& step = *puck.asked;
  if (step.value && value.value != *step.value) {
    const bool goes_on = step.kind == Step::Kind::kStop || step.kind == Step::Kind::kConnection;
    if (goes_on) return;  // it is sent again when its time is over
    if (step.tries < options_.tries) {
      ++step.tries;
      step.sent = now;
      return transmit(value.axis);
    }
    const Step given_up = step;
    puck.asked.reset();
    return give_up(value.axis, given_up, now);
  }
  ++counters_.replies;
  const Step done = step;
  puck.asked.reset();
  take_value(value.axis, done.property, value.value, done, now);
}

void Driver::take_value(std::size_t axis, Property property, std::int32_t value, const Step& step,
                        Time now) {
  Puck& puck = pucks_[axis];
  switch (property) {
    case Property::kStatus: {
      const auto status = static_cast<Status>(value);
      if (step.kind == Step::Kind::kConnection && status == Status::kMonitor) {
        puck.was_asleep = true;
        puck.steps.push_front(
            {Property::kStatus, static_cast<int>(Status::kReady), Step::Kind::kConnection});
        return;
      }
      if (is_connected_ && status == Status::kMonitor) {
        return was_reset(axis, "it is in monitor mode", now);
      }
      const bool is_bad = status != Status::kReady;
      if (is_bad && !puck.is_status_bad) {
        note_(true, std::string(axis_name(axis)) + " shows STAT " + std::to_string(value));
        puck.steps.push_back({Property::kError});
        if (reading_.moving) stop(now, std::string(axis_name(axis)) + " is in error");
      }
      puck.is_status_bad = is_bad;
      break;
    }
    case Property::kMode:
      if (value < 0 || value > kLastMode) {
        ++counters_.strange;
        return;
      }
      modes_[axis] = static_cast<Mode>(value);
      puck.last_mode = now;
      puck.mode_asked = step.began;
      puck.fresh_mode = true;
      if (step.kind == Step::Kind::kStop || step.kind == Step::Kind::kConnection) {
        puck.stop_answered = true;
      }
      if (step.kind == Step::Kind::kStop)
        puck.steps.push_front({Property::kPosition, {}, Step::Kind::kPark});
      look_at_axis(axis, now);
      count_round();
      break;
    case Property::kVersion:
      if (axis == 0) reading_.firmware = std::to_string(value);
      break;
    case Property::kError:
      reading_.error_code = value;
      break;
    case Property::kUptime:
      return take_uptime(axis, value, now);
    case Property::kTactileId:
      reading_.pad_fails[axis] = value == kPadNotInitialised;
      break;
    case Property::kStrain:
      if (value < 0 || value > 4095) {
        ++counters_.strange;
        return;
      }
      puck.gauge = value;
      reading_.effort[axis] = (puck.gauge - puck.gauge_rest) / kGaugeMiddle * options_.gauge_range;
      break;
    case Property::kTemperature:
    case Property::kThermistor: {
      constexpr int kColdest = -40, kHottest = 200;  // degree Celsius
      if (value < kColdest || value > kHottest) {
        ++counters_.strange;
        return;
      }
      auto& of = property == Property::kThermistor ? reading_.motor_temperature
                                                   : reading_.puck_temperature;
      of[axis] = value;
      break;
    }
    default:
      break;
  }
  puck_goes_on(axis, now);
}

// A puck's connection goes on by what it has answered; nothing once it is connected.
void Driver::puck_goes_on(std::size_t axis, Time) {
  Puck& puck = pucks_[axis];
  if (puck.is_connected || puck.asked || !puck.steps.empty()) return;
  const auto add = [&](Property property, std::optional<std::int32_t> value = {},
                       Step::Kind kind = Step::Kind::kConnection) {
    puck.steps.push_back({property, value, kind});
  };
  if (!puck.stop_answered) {
    add(Property::kMode, static_cast<int>(Mode::kIdle));
    add(Property::kVersion, {}, Step::Kind::kOptional);
    add(Property::kUptime, {}, Step::Kind::kOptional);
    add(Property::kTactileId, {}, Step::Kind::kOptional);
    add(Property::kHold, axis == kSpread ? 1 : 0);
    add(Property::kStallTime, static_cast<std::int32_t>(std::lround(1e3 * options_.stall_time)));
    add(Property::kPosition);
  }
}

void Driver::take_uptime(std::size_t axis, int uptime, Time now) {
  Puck& puck = pucks_[axis];
  if (puck.uptime) {
    // 16 bits of seconds, which begin anew after hours; a puck that has no clock shows none pass.
    constexpr double kSlack = 3;  // s
    const auto passed = static_cast<std::uint16_t>(uptime - *puck.uptime);
    const double here = to_seconds(now - puck.uptime_at);
    if (passed > 1.1 * here + kSlack) {
      puck.uptime.reset();
      return was_reset(axis, "its clock went back", now);
    }
  }
  puck.uptime = uptime;
  puck.uptime_at = now;
  puck_goes_on(axis, now);
}

void Driver::was_reset(std::size_t axis, const char* how, Time now) {
  if (is_initialised_ || is_connected_) {
    note_(true, std::string(axis_name(axis)) + " was switched off and on (" + how +
                    "): the hand has to be initialised again");
  }
  is_initialised_ = false;
  if (is_connected_) begin_anew("the connection begins anew", now);
  puck_goes_on(axis, now);
}

void Driver::take(const Position& position, Time now) {
  constexpr double kBeyond = 0.3;     // rad beyond the range: no hand shows that
  constexpr std::size_t kWindow = 6;  // readings, over which a speed is looked at
  Puck& puck = pucks_[position.axis];
  const std::size_t axis = position.axis;
  if (!puck.asked || puck.asked->property != Property::kPosition) {
    ++counters_.strange;
    return;
  }
  const double motor = position.motor / options_.gearing.counts_per_radian(axis);
  const Limits& limits = options_.limits;
  const bool can_be = !is_initialised_ || (motor > limits.lower[axis] - kBeyond &&
                                           motor < limits.upper[axis] + kBeyond);
  if (!can_be && puck.is_connected) {
    ++counters_.strange;
    return;
  }
  ++counters_.replies;
  const Step done = *puck.asked;
  puck.asked.reset();
  const bool has_encoder = position.joint && axis != kSpread;
  const double joint =
      has_encoder ? *position.joint / options_.gearing.joint_counts_per_radian() : motor;
  if (axis == 0) reading_.has_joint_encoders = has_encoder;
  puck.samples.push_back({now, motor, joint});
  if (puck.samples.size() > kWindow) puck.samples.pop_front();
  reading_.position[axis] = motor;
  reading_.joint[axis] = joint;
  reading_.clutch_open[axis] = std::abs(motor - joint) > options_.clutch_tolerance;
  const Sample& first = puck.samples.front();
  const double passed = to_seconds(now - first.time);
  reading_.velocity[axis] = passed > 0 ? (motor - first.motor) / passed : 0;
  reading_.joint_velocity[axis] = passed > 0 ? (joint - first.joint) / passed : 0;
  puck.last_position = now;
  puck.fresh_position = true;
  if (!puck.is_connected && done.kind == Step::Kind::kConnection) {
    puck.steps.push_back({Property::kDefaultPosition, position.motor, Step::Kind::kConnection});
    puck.is_connected = true;  // but for that, which goes on until it is answered
  } else if (done.kind == Step::Kind::kPark) {
    puck.steps.push_front({Property::kDefaultPosition, position.motor, Step::Kind::kPark});
  }
  count_round();
}

void Driver::take(const TactilePart& part, Time) {
  if (const auto cells = pucks_[part.axis].pad.add(part); cells && on_pad_) {
    on_pad_(part.axis, *cells);
  }
}

// When all have told where they are and what they do.
void Driver::count_round() {
  for (const Puck& puck : pucks_) {
    if (!puck.fresh_position || !puck.fresh_mode) return;
  }
  for (Puck& puck : pucks_) puck.fresh_position = puck.fresh_mode = false;
  if (!is_connected_) {
    if (!all_connected()) return;
    is_connected_ = true;
    lost_ = false;
    if (std::ranges::any_of(pucks_, [](const Puck& puck) { return puck.was_asleep; })) {
      is_initialised_ = false;  // its supply was off
    }
    note_(false, "the hand answers: firmware " + reading_.firmware);
  }
  ++reading_.states;
  look_whether_it_moves();
}

}  // namespace prehend::drivers::barrett
