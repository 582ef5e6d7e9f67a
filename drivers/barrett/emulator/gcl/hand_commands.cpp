// What the emulated BH8-262 makes of its commands.

#include <algorithm>
#include <charconv>
#include <cmath>

#include "drivers/barrett/emulator/gcl/hand.h"

namespace prehend::drivers::barrett::gcl {
namespace {

// Of a motor. Defaults of those that the manuals give none for are estimates.
struct Known {
  const char* name;
  int finger, spread;  // defaults
  int least, most;
  bool read_only = false, is_late = false;  // firmware 4.4 alone
};
constexpr Known kMotorProperties[] = {
    {"P", 0, 0, 0, 0, true},
    {"S", 0, 0, 0, 0, true},
    {"SG", 0, 0, 0, 0, true},
    {"CT", 17500, 3150, 0, 18000},
    {"OT", 0, 0, 0, 18000},
    {"DP", 4500, 1575, 0, 18000},
    {"DS", 1000, 200, 0, 18000},
    {"MCV", 100, 60, 16, 4080},
    {"MOV", 100, 60, 16, 4080},
    {"ACCEL", 4, 2, 0, 255},
    {"HSG", 256, 256, 0, 256},
    {"MSG", 256, 256, 0, 256},
    {"LSG", 0, 0, 0, 256},
    {"TSTOP", 150, 150, 0, 10000},
    {"MPE", 50, 20, 0, 18000},
    {"HOLD", 0, 1, 0, 1},
    {"EN", 1, 1, 0, 1},
    {"IVEL", 100, 60, 16, 4080},
    {"IOFF", 0, 0, 0, 18000},
    {"IHIT", 0, 0, 0, 255},
    {"SGFLIP", 0, 0, 0, 1},
    {"FPG", 10, 5, 0, 255},
    {"FIP", 0, 1, 0, 255},
    {"FDZ", 0, 100, 0, 255},
    {"BD", 0, 0, 0, 1},
    {"BP", 0, 0, 0, 20000},
    {"BS", 0, 0, 0, 1},
    {"BDAT", 0, 0, 0, 255},
    {"OD", 0, 0, 0, 0, true},
    {"LCV", 1, 1, 0, 1},
    {"LCVC", 1, 1, 0, 255},
    {"LCPG", 1, 1, 0, 1},
    {"LFV", 1, 1, 0, 1},
    {"LFVC", 1, 1, 0, 255},
    {"LFS", 1, 1, 0, 1},
    {"LFAP", 1, 1, 0, 1},
    {"LFDP", 1, 1, 0, 1},
    {"LFDPC", 1, 1, 0, 255},
    {"LCT", 0, 0, 0, 1, false, true},
    {"LFBP", 0, 0, 0, 1, false, true},
    {"LFAIN", 0, 0, 0, 1, false, true},
};
struct KnownGlobal {
  const char* name;
  int value, least, most;
  bool read_only = false;
};
constexpr KnownGlobal kGlobals[] = {{"BAUD", 96, 6, 384},      {"TEMP", 250, 0, 0, true},
                                    {"PTEMP", 250, 0, 1250},   {"OTEMP", 650, 0, 1250},
                                    {"LFT", 0, 0, 1},          {"LFDPD", 0, 0, 1},
                                    {"UPSECS", 0, 0, 0, true}, {"SN", 262, 0, 0, true}};

const Known* known(const std::string& name, Firmware firmware) {
  const auto* found =
      std::ranges::find_if(kMotorProperties, [&](const Known& one) { return name == one.name; });
  const bool is_there =
      found != std::end(kMotorProperties) && (!found->is_late || firmware == Firmware::k4_4);
  return is_there ? found : nullptr;
}

const KnownGlobal* known_global(const std::string& name) {
  const auto* found =
      std::ranges::find_if(kGlobals, [&](const KnownGlobal& one) { return name == one.name; });
  return found == std::end(kGlobals) ? nullptr : found;
}

std::optional<int> integer(const std::string& text) {
  const std::vector<int> values = integers_of(text);
  return values.size() == 1 ? std::optional(values.front()) : std::nullopt;
}

bool takes_motors(const std::string& command) {
  constexpr std::string_view kCommands[] = {"HI",   "C",     "O",     "M",    "HOME",  "IC",
                                            "IO",   "TC",    "TO",    "T",    "LOOP",  "FGET",
                                            "FSET", "FLOAD", "FSAVE", "FDEF", "FLIST", "FLISTV"};
  return std::ranges::find(kCommands, command) != std::end(kCommands);
}

std::string joined(const std::vector<int>& values) {
  std::string text;
  for (const int value : values) text += (text.empty() ? "" : " ") + std::to_string(value);
  return text;
}

}  // namespace

void Hand::power_on() {
  state_ = State::kBooting;
  line_.clear();
  block_.clear();
  next_baud_.reset();
  spread_waits_ = false;
  const bool is_first = stored_globals_.empty();
  if (is_first) {
    for (const KnownGlobal& one : kGlobals) stored_globals_[one.name] = one.value;
    stored_globals_["BAUD"] = static_cast<int>(options_.baud / 100);
  }
  globals_ = stored_globals_;
  baud_ = static_cast<unsigned>(globals_["BAUD"]) * 100;
  for (std::size_t i = 0; i < kAxes; ++i) {
    Motor& motor = motors_[i];
    if (is_first) {
      for (const Known& one : kMotorProperties) {
        motor.stored[one.name] = i == kSpread ? one.spread : one.finger;
      }
    }
    motor.active = motor.stored;
    motor.active["S"] = is_first && options_.is_initialised ? 0 : static_cast<int>(kNotInitialised);
    motor.task = Motor::Task::kOff;
    motor.velocity = motor.reference = 0;
    if (!is_first) motor.zero = motion_.position[i];
  }
}

bool Hand::is_initialised() const {
  return std::ranges::none_of(
      motors_, [](const Motor& motor) { return (motor.active.at("S") & kNotInitialised) != 0; });
}

std::array<bool, kAxes> Hand::motors_of(const Request& request) const {
  if (request.has_motors()) return request.motors;
  std::array<bool, kAxes> enabled{};
  for (std::size_t i = 0; i < kAxes; ++i) enabled[i] = motors_[i].active.at("EN") != 0;
  return enabled;
}

void Hand::carry_out(const Request& request, Time now) {
  const std::string& command = request.command;
  if (deaf_to_ == command) return;
  const std::array<bool, kAxes> motors = motors_of(request);
  Words lines;
  int error = 0;
  if (request.has_motors() && !takes_motors(command)) {
    error = kTakesNoMotors;
  } else if (refusal_ != 0 && !command.empty()) {
    error = refusal_;
  } else if (command == "LOOP") {
    error = begin_loop(motors);
    if (error == 0) return put(std::string_view(&kLooping, 1), now);
  } else if (command == "FGET" || command == "FSET") {
    error = get_or_set({motors, command, request.words}, lines);
  } else if (command == "PGET" || command == "PSET") {
    error = get_or_set_global(request, lines);
  } else if (command == "VERS") {
    lines.push_back(options_.firmware == Firmware::k4_3 ? "BarrettHand 4.31" : "BarrettHand 4.40");
  } else if (command == "RESET") {
    put(kEndOfLine, now);
    return reboot(now);
  } else if (command == "T") {
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (motors[i]) switch_off(i);
    }
  } else if (takes_motors(command) && command.front() == 'F') {
    error = copy_properties(command, motors);
    if (command.starts_with("FLIST")) lines.push_back("P S SG");  // its layout is not published
  } else if (command == "PLOAD") {
    globals_ = stored_globals_;
  } else if (command == "PSAVE") {
    stored_globals_ = globals_;
  } else if (takes_motors(command)) {
    error = move(request, motors);
  } else if (!command.empty()) {
    error = kUnknownCommand;
  }
  put(kEndOfLine, now);
  // Its prompt comes at the new rate.
  if (next_baud_) return;
  if (state_ != State::kRunning) answer(error, lines, now);
}

int Hand::move(const Request& request, const std::array<bool, kAxes>& motors) {
  const std::string& command = request.command;
  const bool initialises = command == "HI";
  if (temperature_ >= options_.hot) return kOverTemperature;
  std::optional<int> given;
  if (request.words.size() > 1) return kTooManyArguments;
  if (!request.words.empty() && !(given = integer(request.words.front()))) return kInvalidValue;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motors[i] && !initialises && (motors_[i].active["S"] & kNotInitialised) != 0) {
      return kNotInitialised;
    }
  }
  ++moves_;
  run_error_ = 0;
  state_ = State::kRunning;
  for (std::size_t i = 0; i < kAxes; ++i) {
    Motor& motor = motors_[i];
    if (!motors[i]) continue;
    motor.active["S"] &= ~(kAborted | kNotReached);
    const double here = position(i);
    if (initialises) {
      motor.active["BD"] = motor.active["BP"] = 0;
      motor.task = Motor::Task::kInitialise;
      motor.standing_at = here;
      motor.standing_since = motion_.time;
      continue;
    }
    const bool closes = command == "C" || command == "TC" || command == "IC";
    const int step = given.value_or(motor.active["DS"]);
    if (command == "O" || command == "TO") motor.active["BD"] = motor.active["BP"] = 0;
    const double target = command == "M"           ? given.value_or(motor.active["DP"])
                          : command == "HOME"      ? 0
                          : command.front() == 'I' ? here + (closes ? step : -step)
                                                   : motor.active[closes ? "CT" : "OT"];
    begin_move(i, target, command == "M" || command == "HOME" || command.front() == 'I');
  }
  // The spread waits until the fingers are open: they may stand in its way.
  spread_waits_ = initialises && motors[kSpread];
  if (spread_waits_) motors_[kSpread].task = Motor::Task::kOff;
  return 0;
}

int Hand::value_of(std::size_t motor, const std::string& name) {
  if (name == "P") return static_cast<int>(std::lround(position(motor)));
  if (name == "SG") return strain(motor);
  return motors_[motor].active[name];
}

int Hand::get_or_set(const Request& request, Words& lines) {
  const bool sets = request.command == "FSET";
  if (sets && request.words.size() % 2 != 0) return kInvalidValue;
  std::vector<int> values;
  for (std::size_t k = 0; k < request.words.size(); k += sets ? 2 : 1) {
    const std::string& name = request.words[k];
    const Known* property = known(name, options_.firmware);
    if (property == nullptr) return kUnknownProperty;
    if (sets && property->read_only) return kReadOnly;
    const auto value = sets ? integer(request.words[k + 1]) : std::optional(0);
    if (sets && (!value || *value < property->least || *value > property->most)) {
      return kInvalidValue;
    }
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (!request.motors[i]) continue;
      if (sets) {
        motors_[i].active[name] = *value;
      } else {
        values.push_back(value_of(i, name));
      }
    }
  }
  if (!sets) lines.push_back(joined(values));
  return 0;
}

int Hand::get_or_set_global(const Request& request, Words& lines) {
  const bool sets = request.command == "PSET";
  if (sets && request.words.size() % 2 != 0) return kInvalidValue;
  globals_["TEMP"] = static_cast<int>(std::lround(10 * temperature_));
  std::vector<int> values;
  for (std::size_t k = 0; k < request.words.size(); k += sets ? 2 : 1) {
    const std::string& name = request.words[k];
    const KnownGlobal* property = known_global(name);
    if (property == nullptr) return kUnknownProperty;
    if (!sets) {
      values.push_back(globals_[name]);
      continue;
    }
    if (property->read_only) return kReadOnly;
    const auto value = integer(request.words[k + 1]);
    if (!value || *value < property->least || *value > property->most) return kInvalidValue;
    const unsigned baud = static_cast<unsigned>(*value) * 100;
    if (name == "BAUD") {
      if (std::ranges::find(kBauds, baud) == kBauds.end()) return kInvalidValue;
      next_baud_ = baud;
    }
    globals_[name] = *value;
  }
  if (!sets) lines.push_back(joined(values));
  return 0;
}

int Hand::copy_properties(const std::string& command, const std::array<bool, kAxes>& motors) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    Motor& motor = motors_[i];
    if (!motors[i]) continue;
    const int status = motor.active["S"];
    if (command == "FLOAD") motor.active = motor.stored;
    if (command == "FSAVE") motor.stored = motor.active;
    if (command == "FDEF") {
      for (const Known& one : kMotorProperties) {
        motor.active[one.name] = i == kSpread ? one.spread : one.finger;
      }
    }
    motor.active["S"] = status;
  }
  return 0;
}

int Hand::begin_loop(const std::array<bool, kAxes>& motors) {
  Layout layout;
  layout.firmware = options_.firmware;
  layout.temperature = globals_["LFT"] != 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    Motor& motor = motors_[i];
    const auto has = [&](const char* name) { return motor.active[name] != 0; };
    layout.motors[i] = {.loops = motors[i],
                        .velocity = has("LCV"),
                        .gain = has("LCPG"),
                        .torque = has("LCT"),
                        .speed = has("LFV"),
                        .strain = has("LFS"),
                        .position = has("LFAP"),
                        .delta = has("LFDP"),
                        .breakaway = has("LFBP"),
                        .analog = has("LFAIN"),
                        .velocity_coefficient = motor.active["LCVC"],
                        .speed_coefficient = std::max(1, motor.active["LFVC"]),
                        .delta_coefficient = std::max(1, motor.active["LFDPC"])};
    if (!motors[i]) continue;
    if ((motor.active["S"] & kNotInitialised) != 0) return kNotInitialised;
  }
  if (!layout.problem().empty()) return kInvalidValue;
  if (temperature_ >= options_.hot) return kOverTemperature;
  ++moves_;
  layout_ = layout;
  state_ = State::kInLoop;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motors[i]) control({});
    motors_[i].told = static_cast<int>(std::lround(position(i)));
    motors_[i].active["S"] &= ~(kAborted | kNotReached);
  }
  return 0;
}

}  // namespace prehend::drivers::barrett::gcl
