#include "prehend/graph/link/callback_scope.h"

#include <fmt/core.h>

namespace prehend::graph {
namespace {

thread_local const CallbackScope* innermost = nullptr;

}  // namespace

CallbackScope::CallbackScope(const Clock::State& node, const std::string& source)
    : node_(node), source_(source), outer_(innermost) {
  innermost = this;
}

CallbackScope::~CallbackScope() { innermost = outer_; }

const std::string* CallbackScope::source_of(const Clock::State& node) {
  for (const CallbackScope* scope = innermost; scope; scope = scope->outer_) {
    if (&scope->node_ == &node) return &scope->source_;
  }
  return nullptr;
}

std::string refuse_blocking(const Clock::State& node, const std::string& what,
                            const std::string& instead) {
  const std::string* source = CallbackScope::source_of(node);
  if (!source) return "";
  return fmt::format(
      "{} is refused inside a callback ({}), as it would hold up all callbacks of this node: {}",
      what, *source, instead);
}

}  // namespace prehend::graph
