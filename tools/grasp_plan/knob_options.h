#pragma once

#include <algorithm>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "prehend/text/command_line.h"
#include "prehend/text/knob.h"

namespace prehend::tools {

/// Declares an option for each knob of an options struct: --lift-acceleration for
/// lift_acceleration, after `prefix`. What is given goes to `given` by the knob's name (see
/// text::SetKnobs), as the default may depend on what else is given.
struct OfferKnobs {
  CLI::App& command;
  std::map<std::string, double>* given;
  std::string group;
  std::string prefix = {};

  template <class Value>
  void operator()(const text::Knob<Value>& knob) const {
    const std::string name(knob.name);
    std::string option = "--" + prefix + name;
    std::replace(option.begin(), option.end(), '_', '-');
    std::string help(knob.description);
    if (!knob.unit.empty()) help.append(" [").append(knob.unit).append("]");
    CLI::Option* added = command.add_option_function<Value>(
        option,
        [given = given, name](const Value& value) { (*given)[name] = static_cast<double>(value); },
        help);
    if (knob.unit == "s") added->transform(text::in_seconds());
    if (knob.unit == "m") added->transform(text::in_metres());
    added->check(text::in_range(static_cast<Value>(knob.least), static_cast<Value>(knob.most)))
        ->group(group);
  }
};

}  // namespace prehend::tools
