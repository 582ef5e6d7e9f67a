#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
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

/// Holds an action server: destroying it cancels the running goal and waits for its handler, unless
/// it is the handler itself that does so.
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

struct GoalOptions {
  /// [wall time] After this the goal is cancelled and ends as kTimeout, whatever the server does;
  /// 0: never.
  std::chrono::nanoseconds timeout{0};
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
  void on_end_core(std::function<void(Status, const std::string& error, const std::string* result)>
                       callback) const;

  std::shared_ptr<GoalCore> goal_;
};

template <class Result>
class GoalHandle : public GoalHandleBase {
 public:
  GoalHandle() = default;
  explicit GoalHandle(std::shared_ptr<GoalCore> goal) : GoalHandleBase(std::move(goal)) {}

  /// Waits for the result, at most `timeout` (wall time); kTimeout leaves the goal running, wait
  /// again or cancel. Ends at once with kServerGone when the server dies. Feedback that comes
  /// meanwhile is given to the callback in this thread, so that a node need not spin for it. Inside
  /// one of the node's own callbacks only wait(0) may be asked, which looks and never waits; more
  /// is refused at once (kRefused): use on_result there.
  Outcome<Result> wait(std::chrono::nanoseconds timeout) const {
    Result result;
    bool has_result = false;
    std::string error;
    const Status status = wait_core(result, has_result, timeout, error);
    if (status == Status::kOk) return Outcome<Result>(std::move(result));
    if (has_result) return Outcome<Result>(status, std::move(error), std::move(result));
    return Outcome<Result>(status, std::move(error));
  }

  /// `callback` is called once, among the node's callbacks, after the last feedback, with what
  /// wait() would return then; also when the goal has ended already. It is not called when this
  /// node shuts down before. Each call adds a callback.
  void on_result(std::function<void(const Outcome<Result>&)> callback) const {
    if (!callback) throw std::invalid_argument("on_result: no callback given");
    on_end_core([callback = std::move(callback)](Status status, const std::string& error,
                                                 const std::string* bytes) {
      Result result;
      if (!bytes) return callback({status, error});
      if (!result.ParseFromString(*bytes)) {
        return callback({Status::kFailed, "the result is damaged"});
      }
      if (status == Status::kOk) return callback(std::move(result));
      callback({status, error, std::move(result)});
    });
  }
};

/// What all action clients share. Cheap to copy. All functions may be called from any thread.
class ActionClientBase {
 public:
  /// Waits until a server is there; `timeout` is wall time. Sending does not need this. Throws
  /// std::logic_error inside one of the node's callbacks, unless the timeout is 0.
  bool wait_for_server(std::chrono::nanoseconds timeout) const;
  const std::string& action() const;

 protected:
  using RawFeedback = std::function<void(const std::string& bytes)>;
  ActionClientBase() = default;
  explicit ActionClientBase(std::shared_ptr<ActionClientCore> core) : core_(std::move(core)) {}
  std::shared_ptr<GoalCore> send_core(const google::protobuf::Message& goal,
                                      RawFeedback on_feedback,
                                      const GoalOptions& options = {}) const;

  std::shared_ptr<ActionClientCore> core_;
};

template <class Goal, class Feedback, class Result>
class ActionClient : public ActionClientBase {
 public:
  ActionClient() = default;
  explicit ActionClient(std::shared_ptr<ActionClientCore> core)
      : ActionClientBase(std::move(core)) {}

  /// Sends a goal, as soon as a server is known. A server runs one goal at a time: the new one
  /// preempts the one before. `on_feedback` runs among the node's callbacks or in wait(), in the
  /// order it was sent. Throws std::invalid_argument when the timeout is negative.
  GoalHandle<Result> send(const Goal& goal,
                          std::function<void(const Feedback&)> on_feedback = nullptr,
                          const GoalOptions& options = {}) const {
    RawFeedback raw;
    if (on_feedback) {
      raw = [on_feedback = std::move(on_feedback)](const std::string& bytes) {
        Feedback feedback;
        if (!feedback.ParseFromString(bytes)) throw std::runtime_error("feedback is damaged");
        on_feedback(feedback);
      };
    }
    return GoalHandle<Result>(send_core(goal, std::move(raw), options));
  }
};

}  // namespace prehend::graph
