#include "drivers/barrett/node/settings.h"

#include <cmath>

#include "drivers/barrett/node/hand_axes.h"
#include "nodes/platform_source/platform_source.h"

namespace prehend::drivers::barrett {

Gearing declare_gearing(graph::Node& node) {
  Gearing gearing;
  const auto turns = [&](const char* name, double value, const char* words) {
    return node.declare_parameter<double>({.name = name,
                                           .default_value = value,
                                           .minimum = 1,
                                           .maximum = 1000,
                                           .description = words,
                                           .read_only = true});
  };
  gearing.finger =
      turns("finger_gear", gearing.finger,
            "turns of a finger's motor for one of its inner joint; pyHand's counts make 122.4");
  gearing.encoder = turns("encoder_gear", gearing.encoder,
                          "turns of the encoder behind a finger's clutch for one of its joint");
  gearing.spread =
      turns("spread_gear", gearing.spread, "turns of the spread's motor for one of the spread");
  return gearing;
}

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.bus = node.declare_parameter<std::string>(
      {.name = "can",
       .default_value = "can0",
       .description = "a CAN interface, or slcan:/dev/ttyACM0 (serial CAN adapter)",
       .read_only = true});
  s.bit_rate = static_cast<unsigned>(node.declare_parameter<int>(
      {.name = "bit_rate",
       .default_value = kBitRate,
       .unit = "bit/s",
       .minimum = 0,
       .description = "CAN interface: compared with the system's; slcan: set; 0: as it is",
       .read_only = true}));
  s.platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "pa10_barrett",
       .description = "whose hand it is: joints, limits of position, speed and effort, pads",
       .read_only = true});
  s.platforms = nodes::declare_platforms(node);
  s.axes = node.declare_parameter<std::vector<std::string>>(
      {.name = "axes",
       .default_value = kBh8Axes,
       .description = "the hand's joints in the order of the pucks F1, F2, F3, spread",
       .read_only = true});
  s.pads = node.declare_parameter<std::vector<std::string>>(
      {.name = "pads",
       .default_value = kBh8Pads,
       .description = "the hand's pads in the order of the pucks, published as /tactile/NAME; []: "
                      "a hand without pads",
       .read_only = true});
  const auto cells = node.declare_parameter<std::vector<double>>(
      {.name = "cells",
       .minimum = 0,
       .maximum = kCells - 1,
       .description = "place of each of a puck's 24 cells in its pad, row by row from the "
                      "fingertip; []: as they come",
       .read_only = true});
  for (const double cell : cells) s.cells.push_back(static_cast<std::size_t>(std::lround(cell)));
  s.most_torque = node.declare_parameter<double>(
      {.name = "most_torque",
       .default_value = s.most_torque,
       .minimum = 1,
       .maximum = 8191,
       .description = "greatest torque limit of a motor, in the pucks' unit (MT); thought to give "
                      "its joint's greatest effort, so that efforts become limits in proportion",
       .read_only = true});
  s.driver.gauge_range = node.declare_parameter<double>(
      {.name = "gauge_range",
       .default_value = s.driver.gauge_range,
       .unit = "N m",
       .minimum = 0.01,
       .maximum = 100,
       .description = "fingertip torque at the strain gauges' full scale, from their rest",
       .read_only = true});
  s.driver.gearing = declare_gearing(node);
  const auto initialisation = node.declare_parameter<std::string>(
      {.name = "initialise",
       .default_value = "asked",
       .choices = {"asked", "at_start", "done"},
       .description = "asked: by /hand/initialise alone | at_start: once after the first "
                      "connection, too, and the hand opens whatever it holds | done: it was, and "
                      "the zero of a hand that is awake is believed",
       .read_only = true});
  s.driver.initialisation = initialisation == "at_start" ? Initialisation::kAtStart
                            : initialisation == "done"   ? Initialisation::kDone
                                                         : Initialisation::kAsked;
  s.driver.initial_velocity = node.declare_parameter<double>(
      {.name = "initial_velocity",
       .default_value = s.driver.initial_velocity,
       .unit = "counts/ms",
       .minimum = 1,
       .maximum = 200,
       .description = "of motors while the hand initialises, at most",
       .read_only = true});
  s.other_joints = node.declare_parameter<std::string>(
      {.name = "other_joints",
       .default_value = "",
       .description = "topic whose joints, those of the arm, are told with the hand's on "
                      "/joint_states; empty: none",
       .read_only = true});
  const auto seconds = [&](const char* name, double value, double least, const char* words) {
    return node.declare_parameter<double>({.name = name,
                                           .default_value = value,
                                           .unit = "s",
                                           .minimum = least,
                                           .maximum = 30,
                                           .description = words,
                                           .read_only = true});
  };
  DriverOptions& d = s.driver;
  d.state_period = seconds("state_period", d.state_period, 0.005, "between rounds of readings");
  d.tactile_period =
      seconds("tactile_period", d.tactile_period, 0.01, "between images of the pads");
  if (s.pads.empty()) d.tactile_period = 0;
  d.watchdog = seconds("watchdog", d.watchdog, 0.01,
                       "without a command while moving by /hand/command, then it is stopped");
  d.loss_time =
      seconds("loss_time", d.loss_time, 0.05, "without a state of a puck, then it is stopped");
  d.reply_time =
      seconds("reply_time", d.reply_time, 0.005, "to wait for an answer before trying again");
  d.stall_time = seconds("stall_time", d.stall_time, 0.02,
                         "of standing before its target, then a motor is off (TSTOP)");
  d.begin_time =
      seconds("begin_time", d.begin_time, 0.02, "in which a puck's mode has to show a motion");
  d.stop_time = seconds("stop_time", d.stop_time, 0.1,
                        "of motion after a stop was answered, then motors are told to switch off");
  d.stretch = seconds("stretch", d.stretch, 0.1,
                      "that a speed of /hand/command goes on by itself when bus or driver die");
  d.initialise_time = seconds("initialise_time", d.initialise_time, 1,
                              "that the initialisation of fingers, or of the spread, may take");
  s.guardian = node.declare_parameter<bool>(
      {.name = "guardian",
       .default_value = s.guardian,
       .description = "a process of its own stops the hand when this one dies or hangs",
       .read_only = true});
  s.guardian_time = seconds("guardian_time", s.guardian_time, 0.1,
                            "without progress of this process while the hand moves, then its "
                            "guardian stops it");
  s.hot = node.declare_parameter<double>(
      {.name = "hot",
       .default_value = s.hot,
       .unit = "degC",
       .minimum = 30,
       .maximum = 120,
       .description = "temperature of motor or puck from which on it is told; pucks give less "
                      "torque from 44 on, and none at 60 (OTEMP)",
       .read_only = true});
  return s;
}

}  // namespace prehend::drivers::barrett
