#include "drivers/pg70/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::pg70 {
namespace {

void check_positive(double value, const char* name) {
  if (!(std::isfinite(value) && value > 0)) {
    throw std::invalid_argument(std::string("PG70: ") + name + " must be positive and finite");
  }
}

}  // namespace

const char* to_string(DriverState state) {
  switch (state) {
    case DriverState::kDisconnected:
      return "disconnected";
    case DriverState::kConnecting:
      return "connecting";
    case DriverState::kLost:
      return "lost";
    case DriverState::kFault:
      return "fault";
    case DriverState::kUnreferenced:
      return "unreferenced";
    case DriverState::kReferencing:
      return "referencing";
    case DriverState::kStanding:
      return "standing";
    case DriverState::kMoving:
      return "moving";
    case DriverState::kHolding:
      return "holding";
  }
  return "?";
}

Driver::Driver(const DriverOptions& options, Send send, Note note)
    : options_(options), send_(std::move(send)), note_(std::move(note)) {
  check_positive(options.limits.max_opening, "max_opening");
  check_positive(options.limits.max_speed, "max_speed");
  check_positive(options.limits.max_acceleration, "max_acceleration");
  check_positive(options.limits.nominal_current, "nominal_current");
  check_positive(options.limits.max_current, "max_current");
  check_positive(options.opening_per_position, "opening_per_position");
  check_positive(options.state_period, "state_period");
  check_positive(options.watchdog, "watchdog");
  check_positive(options.loss_time, "loss_time");
  check_positive(options.reply_time, "reply_time");
  check_positive(options.blocked_time, "blocked_time");
  check_positive(options.stop_time, "stop_time");
  check_positive(options.grip_give, "grip_give");
  check_positive(options.opening_tolerance, "opening_tolerance");
  if (!(options.holding_current >= 0 && options.holding_current <= 1)) {
    throw std::invalid_argument("PG70: holding_current must be from 0 to 1");
  }
  if (options.tries < 1) throw std::invalid_argument("PG70: tries must be at least 1");
  if (options.limits.nominal_current > options.limits.max_current) {
    throw std::invalid_argument("PG70: nominal_current must not be above max_current");
  }
}

void Driver::connected(Time now) {
  link_up_ = has_link_ = true;
  begin_connecting(now);
}

void Driver::link_event(const LinkEvent& event, Time now) {
  switch (event.kind) {
    case LinkEvent::Kind::kDisturbed:
      return note_(true, event.words);
    case LinkEvent::Kind::kUp:
      note_(false, event.words);
      if (!link_up_) connected(now);
      return;
    default:
      has_link_ = event.kind == LinkEvent::Kind::kDown;
      last_probe_ = now;
      if (!link_up_) return;
      note_(true, event.kind == LinkEvent::Kind::kLeft
                      ? event.words
                      : event.words +
                            "; nothing can be sent, so a motion goes on until the module ends it");
      link_up_ = false;
      lost_ = false;
      stopping_.reset();
      end_motion(event.words);
      update_state();
  }
}

// CMD STOP comes first: whatever the module was doing, a new connection does not go on with it.
void Driver::begin_connecting(Time now) {
  stop_confirmed_ = unit_known_ = lost_ = referencing_ = fault_told_ = false;
  obstacle_.clear();
  ++counters_.connections;
  reading_.states = 0;
  fast_states_ = 0;
  outstanding_.clear();
  stopping_.reset();
  end_motion("the connection began anew");
  connecting_since_ = last_state_ = now;
  last_question_ = Time::min();
  check_connection(now);
  update_state();
}

// Asks for what is still missing; asks again when no answer comes.
void Driver::check_connection(Time now) {
  const bool is_complete = stop_confirmed_ && unit_known_ && reading_.states > 0;
  if (is_complete && !lost_) return;
  const Time pause = to_time(options_.reply_time);
  if (last_question_ != Time::min() && now - last_question_ < pause) return;
  last_question_ = now;
  if (!stop_confirmed_) send_(encode(PlainRequest{Command::kStop}));
  if (stop_confirmed_ && !unit_known_) {
    constexpr int kPatience = 10;  // some modules give their configuration to no-one
    const bool has_waited = now - connecting_since_ > kPatience * pause;
    if (has_waited && obstacle_.empty() && reading_.states > 0) {
      note_(true, "the module does not tell its unit system; mm is assumed");
      take_unit(1e-3, now);
    } else {
      send_(encode(GetConfig{static_cast<std::uint8_t>(ConfigParameter::kUnitSystem)}));
    }
  }
  ask_for_states(now);
}

void Driver::ask_for_states(Time now) {
  last_question_ = now;
  const GetState::Cycle cycle{static_cast<float>(options_.state_period), kWithAll};
  send_(encode(GetState{cycle}));
}

std::string Driver::transmit(const Request& request, Time now, bool is_motion) {
  const Content content = encode(request);
  std::erase_if(outstanding_, [&](const Outstanding& o) {
    return o.content.command() == content.command() || (is_motion && o.is_motion);
  });
  const std::string problem = send_(content);
  if (problem.empty()) outstanding_.push_back({content, now, 1, is_motion});
  return problem;
}

void Driver::update(Time now) {
  if (!link_up_) return probe(now);
  for (std::size_t i = 0; i < outstanding_.size();) {
    Outstanding& o = outstanding_[i];
    if (now - o.sent < to_time(options_.reply_time)) {
      ++i;
    } else if (o.tries < options_.tries) {
      ++o.tries;
      ++counters_.unanswered;
      o.sent = now;
      send_(o.content);
      ++i;
    } else {
      const Outstanding given_up = o;
      outstanding_.erase(outstanding_.begin() + static_cast<std::ptrdiff_t>(i));
      const std::string words = "no answer to " + command_name(given_up.content.command());
      ++counters_.unanswered;
      note_(true, words);
      if (!given_up.is_motion) continue;
      stop(now, words);  // it may have arrived nevertheless
      break;             // the list has changed
    }
  }
  check_connection(now);
  const bool is_silent = now - last_state_ > to_time(options_.loss_time);
  if (is_silent && !lost_ && reading_.states > 0) {
    lost_ = true;
    stop_confirmed_ = false;
    last_question_ = Time::min();
    outstanding_.clear();
    char words[96];
    std::snprintf(words, sizeof words,
                  "no state from the module for %g s: CMD STOP is sent until one is answered",
                  options_.loss_time);
    note_(true, words);
    end_motion("the module's answers were lost");
    if (!stopping_) begin_stopping(now, false);
    check_connection(now);
  } else if (!lost_ && reading_.states > 0 &&
             now - std::max(last_state_, last_question_) > 3 * to_time(options_.state_period)) {
    ask_for_states(now);
  }
  watch_stop(now);
  update_motion(now);
  update_state();
}

// An interface that comes up again does not say so.
void Driver::probe(Time now) {
  constexpr double kPause = 0.2;  // s
  if (!has_link_ || now - last_probe_ < to_time(kPause)) return;
  last_probe_ = now;
  if (send_(encode(PlainRequest{Command::kStop})).empty()) connected(now);
}

void Driver::update_state() {
  const bool is_connected = stop_confirmed_ && unit_known_ && reading_.states > 0;
  reading_.state = !link_up_                  ? DriverState::kDisconnected
                   : lost_                    ? DriverState::kLost
                   : !is_connected            ? DriverState::kConnecting
                   : reading_.error_code != 0 ? DriverState::kFault
                   : referencing_             ? DriverState::kReferencing
                   : !reading_.referenced     ? DriverState::kUnreferenced
                   : reading_.moving          ? DriverState::kMoving
                   : reading_.blocked         ? DriverState::kHolding
                                              : DriverState::kStanding;
}

}  // namespace prehend::drivers::pg70
