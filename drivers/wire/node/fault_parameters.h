#pragma once

#include <functional>
#include <utility>

#include "drivers/wire/faults/faulty_line.h"
#include "drivers/wire/node/late_parameter.h"

namespace prehend::drivers {

/// An emulator's parameters for faults of its line: dropped, duplicated, corrupted, late, delay.
class LineFaultParameters {
 public:
  explicit LineFaultParameters(graph::Node& node)
      : dropped_(node, part("dropped", "part of what is sent that is lost")),
        duplicated_(node, part("duplicated", "part of what is sent that comes twice")),
        corrupted_(node, part("corrupted", "part of what is sent that has a wrong bit")),
        late_(node, part("late", "part of what is sent that comes late")),
        delay_(node, {.name = "delay",
                      .default_value = 0.05,
                      .unit = "s",
                      .minimum = 0,
                      .maximum = 10,
                      .description = "of what comes late"}) {}
  /// As LateParameter::connect, with all of them.
  void connect(std::function<void(const LineFaults&)> apply) {
    apply_ = std::move(apply);
    dropped_.connect([this](double value) { change(faults_.dropped, value); });
    duplicated_.connect([this](double value) { change(faults_.duplicated, value); });
    corrupted_.connect([this](double value) { change(faults_.corrupted, value); });
    late_.connect([this](double value) { change(faults_.late, value); });
    delay_.connect([this](double value) { change(faults_.delay, to_time(value)); });
  }

 private:
  static graph::ParameterDeclaration<double> part(const char* name, const char* words) {
    return {.name = name, .default_value = 0, .minimum = 0, .maximum = 1, .description = words};
  }
  template <class Value>
  void change(Value& fault, Value value) {
    fault = value;
    apply_(faults_);
  }

  LineFaults faults_;
  std::function<void(const LineFaults&)> apply_;
  LateParameter<double> dropped_, duplicated_, corrupted_, late_, delay_;
};

/// A switch of an emulator that may be thrown while it runs.
class Switch : public LateParameter<bool> {
 public:
  Switch(graph::Node& node, const char* name, const char* words)
      : LateParameter(node, {.name = name, .default_value = false, .description = words}) {}
};

}  // namespace prehend::drivers
