#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "prehend/graph/outcome.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

class ActionServerCore;
class ActionClientCore;
class GoalCore;  // a goal at its client
class GoalTask;  // a goal at its server

/// Holds an action server: destroying it cancels the running goal and waits for its handler.
class ActionServer {
 public:
  ActionServer() = default;
  explicit ActionServer(std::shared_ptr<ActionServerCore> core);
  ~ActionServer();
  ActionServer(ActionServer&&) noexcept;
  ActionServer& operator=(ActionServer&&) noexcept;

 private:
  std::shared_ptr<ActionServerCore> core_;
};

/// What a goal's handler sees of the world outside.
class ActionContextBase {
 public:
  explicit ActionContextBase(GoalTask& task) : task_(&task) {}
  /// True once the handler should stop soon and return: its client cancelled or died, a newer goal
  /// came, or the node shuts down.
  bool cancelled() const;
  /// True when the reason is a newer goal, so the handler may leave things moving for it.
  bool preempted() const;
  /// Sleeps by the node's clock; false at once when cancelled().
  bool sleep_for(std::chrono::nanoseconds duration) const;
  bool sleep_until(std::int64_t stamp) const;

 protected:
  void send_feedback(const google::protobuf::Message& feedback) const;
  GoalTask* task_;
};

template <class Feedback>
class ActionContext : public ActionContextBase {
 public:
  using ActionContextBase::ActionContextBase;
  /// Sends feedback to the goal's client; does not wait.
  void feedback(const Feedback& message) const { send_feedback(message); }
};

/// A goal that was sent. Cheap to copy; copies are the same goal. Dropping it does not cancel.
class GoalHandleBase {
 public:
  explicit operator bool() const { return goal_ != nullptr; }
  /// True when the result (or the failure) is there: wait() returns at once.
  bool done() const;
  /// Asks the server to stop. When it returns, no feedback callback runs nor will run any more.
  /// The result still comes, with status kCancelled, when the handler has stopped.
  void cancel() const;

 protected:
  GoalHandleBase() = default;
  explicit GoalHandleBase(std::shared_ptr<GoalCore> goal) : goal_(std::move(goal)) {}
  Status wait_core(google::protobuf::Message& result, bool& has_result,
                   std::chrono::nanoseconds timeout, std::string& error) const;

  std::shared_ptr<GoalCore> goal_;
};

template <class Result>
class GoalHandle : public GoalHandleBase {
 public:
  GoalHandle() = default;
  explicit GoalHandle(std::shared_ptr<GoalCore> goal) : GoalHandleBase(std::move(goal)) {}

  /// Waits for the result, at most `timeout` (wall time); kTimeout leaves the goal running, wait
  /// again or cancel. Ends at once with kServerGone when the server dies. Feedback that comes
  /// meanwhile is given to the callback in this thread, so wait() may be called from a callback.
  Outcome<Result> wait(std::chrono::nanoseconds timeout) const {
    Result result;
    bool has_result = false;
    std::string error;
    const Status status = wait_core(result, has_result, timeout, error);
    if (status == Status::kOk) return Outcome<Result>(std::move(result));
    if (has_result) return Outcome<Result>(status, std::move(error), std::move(result));
    return Outcome<Result>(status, std::move(error));
  }
};

/// What all action clients share. Cheap to copy. All functions may be called from any thread.
class ActionClientBase {
 public:
  /// Waits until a server is there; `timeout` is wall time. Sending does not need this.
  bool wait_for_server(std::chrono::nanoseconds timeout) const;
  const std::string& action() const;

 protected:
  using RawFeedback = std::function<void(const std::string& bytes)>;
  ActionClientBase() = default;
  explicit ActionClientBase(std::shared_ptr<ActionClientCore> core) : core_(std::move(core)) {}
  std::shared_ptr<GoalCore> send_core(const google::protobuf::Message& goal,
                                      RawFeedback on_feedback) const;

  std::shared_ptr<ActionClientCore> core_;
};

template <class Goal, class Feedback, class Result>
class ActionClient : public ActionClientBase {
 public:
  ActionClient() = default;
  explicit ActionClient(std::shared_ptr<ActionClientCore> core)
      : ActionClientBase(std::move(core)) {}

  /// Sends a goal, as soon as a server is known. A server runs one goal at a time: the new one
  /// preempts the one before. `on_feedback` runs among the node's callbacks or in wait().
  GoalHandle<Result> send(const Goal& goal,
                          std::function<void(const Feedback&)> on_feedback = nullptr) const {
    RawFeedback raw;
    if (on_feedback) {
      raw = [on_feedback = std::move(on_feedback)](const std::string& bytes) {
        Feedback feedback;
        if (!feedback.ParseFromString(bytes)) throw std::runtime_error("feedback is damaged");
        on_feedback(feedback);
      };
    }
    return GoalHandle<Result>(send_core(goal, std::move(raw)));
  }
};

}  // namespace prehend::graph
