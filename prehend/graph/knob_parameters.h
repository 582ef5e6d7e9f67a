#pragma once

#include <string>

#include "prehend/graph/node.h"
#include "prehend/text/knob.h"

namespace prehend::graph {

/// Declares a read-only parameter for each knob of an options struct, named after `prefix`, with
/// its value as default, and sets it.
struct DeclareKnobs {
  Node& node;
  std::string prefix = {};

  template <class Value>
  void operator()(const text::Knob<Value>& knob) const {
    knob.value = node.declare_parameter<Value>({.name = prefix + std::string(knob.name),
                                                .default_value = knob.value,
                                                .unit = std::string(knob.unit),
                                                .minimum = static_cast<Value>(knob.least),
                                                .maximum = static_cast<Value>(knob.most),
                                                .description = std::string(knob.description),
                                                .read_only = true});
  }
};

}  // namespace prehend::graph
