#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "prehend/graph/node.h"

namespace prehend::drivers {

/// A parameter that acts on something which is made later: it is declared first, so that --help
/// lists it, and connected when there is what it acts on.
template <class Type>
class LateParameter {
 public:
  /// `declaration` without on_change.
  LateParameter(graph::Node& node, graph::ParameterDeclaration<Type> declaration) {
    declaration.on_change = [state = state_](const Type& value) {
      state->value = value;
      if (state->apply) state->apply(value);
    };
    state_->value = node.declare_parameter<Type>(declaration);
  }
  /// Calls `apply` now and, among the node's callbacks, after each change. What it refers to must
  /// outlive the node's callbacks.
  void connect(std::function<void(const Type&)> apply) {
    state_->apply = std::move(apply);
    state_->apply(state_->value);
  }

 private:
  struct State {
    Type value{};
    std::function<void(const Type&)> apply;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace prehend::drivers
