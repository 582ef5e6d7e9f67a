#include "drivers/barrett/node/settings.h"

#include <cmath>
#include <utility>

#include "drivers/barrett/node/hand_axes.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::barrett {
namespace {

/// Declares parameters, and refuses those that are not of the model: one that is given, and is
/// another than what it is without.
class Declared {
 public:
  Declared(graph::Node& node, Model model) : node_(node), model_(model) {}

  template <class Type>
  Type any(graph::ParameterDeclaration<Type> declaration) {
    declaration.read_only = true;
    return node_.declare_parameter<Type>(declaration);
  }
  /// Of this model alone.
  template <class Type>
  Type only(Model model, graph::ParameterDeclaration<Type> declaration) {
    const bool is_280 = model == Model::kBh8_280;
    declaration.description = (is_280 ? "BH8-280: " : "BH8-262: ") + declaration.description;
    const Type without = declaration.default_value;
    const std::string name = declaration.name;
    const Type value = any(std::move(declaration));
    if (model != model_ && value != without) {
      throw geometry::InputError(name + " is a parameter of a BH8-" + (is_280 ? "280" : "262") +
                                     ", and this is model:=" + (is_280 ? "bh8_262" : "bh8_280"),
                                 "Leave " + name + " away, or name the model that the hand is");
    }
    return value;
  }
  double seconds(const char* name, double value, double least, const std::string& words) {
    return any<double>(seconds_of(name, value, least, words));
  }
  double only_seconds(Model model, const char* name, double value, double least,
                      const std::string& words) {
    return only<double>(model, seconds_of(name, value, least, words));
  }

 private:
  static graph::ParameterDeclaration<double> seconds_of(const char* name, double value,
                                                        double least, const std::string& words) {
    return {.name = name,
            .default_value = value,
            .unit = "s",
            .minimum = least,
            .maximum = 30,
            .description = words};
  }

  graph::Node& node_;
  Model model_;
};

constexpr double kWarm262 = 62;  // degree Celsius: it normally runs at 40 to 60
constexpr Model k280 = Model::kBh8_280, k262 = Model::kBh8_262;

// What is asked of a bus and its pucks.
void declare_can(Declared& declared, Settings& s) {
  s.wire = declared.only<std::string>(
      k280, {.name = "can",
             .default_value = "can0",
             .description = "a CAN interface, or slcan:/dev/ttyACM0 (serial CAN adapter)"});
  s.bit_rate = static_cast<unsigned>(declared.only<int>(
      k280, {.name = "bit_rate",
             .default_value = kBitRate,
             .unit = "bit/s",
             .minimum = 0,
             .description = "CAN interface: compared with the system's; slcan: set; 0: as it is"}));
  const auto cells = declared.only<std::vector<double>>(
      k280, {.name = "cells",
             .minimum = 0,
             .maximum = kCells - 1,
             .description = "place of each of a puck's 24 cells in its pad, row by row from the "
                            "fingertip; []: as they come"});
  for (const double cell : cells) s.cells.push_back(static_cast<std::size_t>(std::lround(cell)));
  DriverOptions& d = s.can;
  d.initial_velocity =
      declared.only<double>(k280, {.name = "initial_velocity",
                                   .default_value = d.initial_velocity,
                                   .unit = "counts/ms",
                                   .minimum = 1,
                                   .maximum = 200,
                                   .description = "of motors while the hand initialises, at most"});
  d.tactile_period = declared.only_seconds(k280, "tactile_period", d.tactile_period, 0.01,
                                           "between images of the pads");
  d.begin_time = declared.only_seconds(k280, "begin_time", d.begin_time, 0.02,
                                       "in which a puck's mode has to show a motion");
  d.stretch = declared.only_seconds(
      k280, "stretch", d.stretch, 0.1,
      "that a speed of /hand/command goes on by itself when bus or driver die");
}

// What is asked of a serial line and its hand.
void declare_gcl(Declared& declared, Settings& s) {
  const auto line = declared.only<std::string>(
      k262, {.name = "line",
             .default_value = "/dev/ttyUSB2",
             .description = "a serial line, or tcp://HOST:PORT (a serial server)"});
  if (s.model == k262) s.wire = line;
  gcl::DriverOptions& d = s.gcl;
  const auto rate = [&](const char* name, unsigned value, const char* words) {
    std::vector<int> rates(gcl::kBauds.begin(), gcl::kBauds.end());
    if (value == 0) rates.insert(rates.begin(), 0);
    return static_cast<unsigned>(declared.only<int>(k262, {.name = name,
                                                           .default_value = static_cast<int>(value),
                                                           .unit = "bit/s",
                                                           .choices = rates,
                                                           .description = words}));
  };
  d.baud = rate("baud", d.baud, "that the hand has after power-on");
  d.fast_baud =
      rate("fast_baud", d.fast_baud,
           "that is agreed on with the hand in each connection (PSET BAUD); 0: none. At "
           "9600 there are 50 states a second of motion, at 38400 what state_period says");
  if (d.fast_baud != 0 && line.starts_with("tcp://")) {
    throw geometry::InputError("fast_baud:= of " + line + ": a TCP connection has no rate",
                               "Set the rate in the serial server, and leave fast_baud away");
  }
  const auto firmware = declared.only<std::string>(
      k262, {.name = "firmware",
             .default_value = "auto",
             .choices = {"auto", "4.3", "4.4"},
             .description = "what blocks of RealTime mode depend on; auto: as VERS tells"});
  if (firmware != "auto") d.firmware = gcl::firmware_of(firmware);
  d.velocity_factor = declared.only<int>(
      k262, {.name = "velocity_factor",
             .default_value = d.velocity_factor,
             .choices = {1, 16},
             .description = "parts of a count per 10 ms that LCV is counted in: 1 (BHand API), 16 "
                            "(manual of firmware 4.3); a hand that is too fast for it is stopped"});
  d.temperature_unit =
      declared.only<double>(k262, {.name = "temperature_unit",
                                   .default_value = d.temperature_unit,
                                   .unit = "degC",
                                   .minimum = 0,
                                   .maximum = 10,
                                   .description = "of LFT; 0: 0.1 with firmware 4.3, 1 with 4.4"});
  d.strain_range = declared.only<double>(
      k262, {.name = "strain_range",
             .default_value = d.strain_range,
             .unit = "counts",
             .minimum = 1,
             .maximum = 1000,
             .description = "of SG from its rest at a joint's greatest effort; a finger ends its "
                            "motion where its share of that is reached"});
  d.block_time = declared.only_seconds(
      k262, "block_time", d.block_time, 0.01,
      "to wait for feedback in RealTime mode, beyond what the line takes, then Ctrl-C");
  d.linger = declared.only_seconds(k262, "linger", d.linger, 0.02,
                                   "in RealTime mode behind the end of a motion by /hand/command");
}

void declare_hand(graph::Node& node, Declared& declared, Settings& s) {
  const bool is_280 = s.model == k280;
  s.platform = declared.any<std::string>(
      {.name = "platform",
       .default_value = "pa10_barrett",
       .description = "whose hand it is: joints, limits of position, speed and effort, pads"});
  s.platforms = nodes::declare_platforms(node);
  s.axes = declared.any<std::vector<std::string>>(
      {.name = "axes",
       .default_value = kBh8Axes,
       .description = "the hand's joints in the order of the motors F1, F2, F3, spread"});
  s.pads = declared.only<std::vector<std::string>>(
      k280, {.name = "pads",
             .default_value = kBh8Pads,
             .description = "the hand's pads in the order of the pucks, published as "
                            "/tactile/NAME; []: a hand without pads. A BH8-262 has none"});
  if (!is_280) s.pads.clear();
  if (s.pads.empty()) s.can.tactile_period = 0;
  s.most_torque = declared.any<double>(
      {.name = "most_torque",
       .default_value = is_280 ? s.most_torque : gcl::kMostCommand,
       .minimum = 1,
       .maximum = is_280 ? 8191 : gcl::kMostCommand,
       .description = "greatest torque limit of a motor, in the pucks' unit (MT), of a BH8-262 its "
                      "command, at most 127; thought to give its joint's greatest effort, so that "
                      "efforts become limits in proportion"});
  const double gauge_range = declared.any<double>(
      {.name = "gauge_range",
       .default_value = s.can.gauge_range,
       .unit = "N m",
       .minimum = 0.01,
       .maximum = 100,
       .description = "fingertip torque at the strain gauges' full scale, from their rest"});
  s.can.gauge_range = s.gcl.gauge_range = gauge_range;
  (is_280 ? s.can.gearing : s.gcl.gearing) = declare_gearing(node, s.model);
  const auto initialisation = declared.any<std::string>(
      {.name = "initialise",
       .default_value = "asked",
       .choices = {"asked", "at_start", "done"},
       .description = "asked: by /hand/initialise alone | at_start: once after the first "
                      "connection, too, and the hand opens whatever it holds | done: of a BH8-280: "
                      "it was, and the zero of a hand that is awake is believed"});
  if (initialisation == "done" && !is_280) {
    throw geometry::InputError("a BH8-262 tells by itself whether it was initialised",
                               "Leave initialise:=done away");
  }
  s.can.initialisation = initialisation == "at_start" ? Initialisation::kAtStart
                         : initialisation == "done"   ? Initialisation::kDone
                                                      : Initialisation::kAsked;
  s.gcl.initialisation = s.can.initialisation;
  s.other_joints = declared.any<std::string>(
      {.name = "other_joints",
       .default_value = "",
       .description = "topic whose joints, those of the arm, are told with the hand's on "
                      "/joint_states; empty: none"});
}

// What both models' drivers wait for, each with times of its own.
void declare_times(Declared& declared, Settings& s) {
  const auto both = [&](const char* name, double DriverOptions::*can,
                        double gcl::DriverOptions::*gcl, double least, const char* words) {
    const bool is_280 = s.model == k280;
    const std::string other = is_280 ? "; without it " + number(s.gcl.*gcl) + " of a BH8-262"
                                     : "; without it " + number(s.can.*can) + " of a BH8-280";
    double& of = is_280 ? s.can.*can : s.gcl.*gcl;
    of = declared.seconds(name, of, least, words + other);
  };
  using Can = DriverOptions;
  using Gcl = gcl::DriverOptions;
  both("state_period", &Can::state_period, &Gcl::state_period, 0.005, "between rounds of readings");
  both("watchdog", &Can::watchdog, &Gcl::watchdog, 0.01,
       "without a command while moving by /hand/command, then it is stopped");
  both("loss_time", &Can::loss_time, &Gcl::loss_time, 0.05,
       "without a state of the hand, then it is stopped");
  both("reply_time", &Can::reply_time, &Gcl::reply_time, 0.005,
       "to wait for an answer before trying again");
  both("stall_time", &Can::stall_time, &Gcl::stall_time, 0.02,
       "of standing before its target, then a motor is off");
  both("stop_time", &Can::stop_time, &Gcl::stop_time, 0.1,
       "of motion after a stop was answered, then motors are told to switch off");
  both("initialise_time", &Can::initialise_time, &Gcl::initialise_time, 1,
       "that the initialisation may take, of a BH8-280 that of fingers, or of the spread");
}

}  // namespace

Gearing declare_gearing(graph::Node& node, Model model) {
  Declared declared(node, model);
  Gearing gearing = model == k280 ? Gearing() : gcl::kGearing;
  const auto turns = [&](const char* name, double value, const char* words) {
    return graph::ParameterDeclaration<double>{
        .name = name, .default_value = value, .minimum = 1, .maximum = 1000, .description = words};
  };
  gearing.finger = declared.any(
      turns("finger_gear", gearing.finger,
            "turns of a finger's motor for one of its inner joint; pyHand's counts make 122.4"));
  gearing.encoder = declared.only(
      k280, turns("encoder_gear", gearing.encoder,
                  "turns of the encoder behind a finger's clutch for one of its joint"));
  gearing.spread = declared.any(
      turns("spread_gear", gearing.spread, "turns of the spread's motor for one of the spread"));
  return gearing;
}

Settings declare_settings(graph::Node& node) {
  Settings s;
  const auto model = node.declare_parameter<std::string>(
      {.name = "model",
       .default_value = "bh8_280",
       .choices = {"bh8_280", "bh8_262"},
       .description = "bh8_280: over CAN, with four pads | bh8_262: over a serial line, without",
       .read_only = true});
  s.model = model == "bh8_280" ? k280 : k262;
  Declared declared(node, s.model);
  declare_can(declared, s);
  declare_gcl(declared, s);
  declare_hand(node, declared, s);
  declare_times(declared, s);
  s.guardian = declared.any<bool>(
      {.name = "guardian",
       .default_value = s.guardian,
       .description = "a process of its own stops the hand when this one dies or hangs"});
  s.guardian_time = declared.seconds(
      "guardian_time", s.guardian_time, 0.1,
      "without progress of this process while the hand moves, then its guardian stops it");
  s.hot = declared.any<double>(
      {.name = "hot",
       .default_value = s.model == k280 ? s.hot : kWarm262,
       .unit = "degC",
       .minimum = 30,
       .maximum = 120,
       .description = "temperature of motor or electronics from which on it is told; a BH8-280's "
                      "pucks give less torque from 44 on, and none at 60 (OTEMP); a BH8-262 runs "
                      "at 40 to 60, and should stay below 65"});
  return s;
}

}  // namespace prehend::drivers::barrett
