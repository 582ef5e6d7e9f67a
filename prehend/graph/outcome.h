#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace prehend::graph {

/// Why a service call or an action ended.
enum class Status {
  kOk,
  kTimeout,     ///< no answer within the time allowed; an action's goal goes on
  kServerGone,  ///< the server's process ended or its connection broke
  kFailed,      ///< the server's handler threw, or request and handler have different types
  kCancelled,   ///< action: cancelled by its client
  kPreempted,   ///< action: another goal took its place
  kShutdown,    ///< the calling node stops
  kRefused,     ///< a blocking call from inside one of the node's callbacks
};

/// "timeout", "server gone", …
const char* to_string(Status status);

/// The value of a service call or action, or why there is none. An action that was cancelled or
/// preempted may have a value too: what its handler returned when it stopped.
template <class Value>
class Outcome {
 public:
  Outcome(Value value) : status_(Status::kOk), value_(std::move(value)) {}
  Outcome(Status status, std::string error, std::optional<Value> value = std::nullopt)
      : status_(status), error_(std::move(error)), value_(std::move(value)) {}

  /// True when it was done to the end.
  bool ok() const { return status_ == Status::kOk; }
  explicit operator bool() const { return ok(); }
  Status status() const { return status_; }
  /// One line that names the service or action and the reason; empty when ok().
  const std::string& error() const { return error_; }

  bool has_value() const { return value_.has_value(); }
  /// Throws std::runtime_error(error()) when there is no value.
  const Value& value() const {
    if (!value_) throw std::runtime_error(error_);
    return *value_;
  }
  const Value& operator*() const { return value(); }
  const Value* operator->() const { return &value(); }

 private:
  Status status_;
  std::string error_;
  std::optional<Value> value_;
};

}  // namespace prehend::graph
