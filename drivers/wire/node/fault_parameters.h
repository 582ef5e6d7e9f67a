#pragma once

#include <functional>

#include "drivers/wire/faults/faulty_line.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// Declares an emulator's parameters for faults of its line: dropped, duplicated, corrupted, late,
/// delay. `apply` is called with all of them at the start and after each change.
inline void declare_line_faults(graph::Node& node, std::function<void(const LineFaults&)> apply) {
  const auto faults = std::make_shared<LineFaults>();
  const auto probability = [&](const char* name, double LineFaults::*field, const char* words) {
    faults.get()->*field =
        node.declare_parameter<double>({.name = name,
                                        .default_value = 0,
                                        .minimum = 0,
                                        .maximum = 1,
                                        .description = words,
                                        .on_change = [faults, field, apply](const double& value) {
                                          faults.get()->*field = value;
                                          apply(*faults);
                                        }});
  };
  probability("dropped", &LineFaults::dropped, "part of what is sent that is lost");
  probability("duplicated", &LineFaults::duplicated, "part of what is sent that comes twice");
  probability("corrupted", &LineFaults::corrupted, "part of what is sent that has a wrong bit");
  probability("late", &LineFaults::late, "part of what is sent that comes late");
  faults->delay =
      to_time(node.declare_parameter<double>({.name = "delay",
                                              .default_value = 0.05,
                                              .unit = "s",
                                              .minimum = 0,
                                              .maximum = 10,
                                              .description = "of what comes late",
                                              .on_change = [faults, apply](const double& value) {
                                                faults->delay = to_time(value);
                                                apply(*faults);
                                              }}));
  apply(*faults);
}

/// Declares a switch of an emulator that may be thrown while it runs.
inline void declare_switch(graph::Node& node, const char* name, const char* words,
                           std::function<void(bool)> apply) {
  const bool is_on = node.declare_parameter<bool>(
      {.name = name, .default_value = false, .description = words, .on_change = apply});
  if (is_on) apply(true);
}

}  // namespace prehend::drivers
