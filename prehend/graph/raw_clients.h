#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "prehend/graph/action.h"
#include "prehend/graph/service.h"

namespace prehend::graph {

/// A service client for message types that are known at run time only; see ServiceClient.
class RawServiceClient : public ServiceClientBase {
 public:
  RawServiceClient() = default;
  explicit RawServiceClient(std::shared_ptr<ServiceClientCore> core)
      : ServiceClientBase(std::move(core)) {}

  /// Fills `response` when the status is kOk, else `error`.
  Status call(const google::protobuf::Message& request, google::protobuf::Message& response,
              std::chrono::nanoseconds timeout, std::string& error) const {
    return call_core(request, response, timeout, error);
  }
};

/// What a goal's handler of Node::serve_action_raw() sees of the world outside; see ActionContext.
class RawActionContext : public ActionContextBase {
 public:
  using ActionContextBase::ActionContextBase;
  void feedback(const google::protobuf::Message& message) const { send_feedback(message); }
};

/// A goal that was sent by RawActionClient; see GoalHandle.
class RawGoalHandle : public GoalHandleBase {
 public:
  RawGoalHandle() = default;
  explicit RawGoalHandle(std::shared_ptr<GoalCore> goal) : GoalHandleBase(std::move(goal)) {}

  /// Fills `result` when `has_result` is set, as may be after kCancelled and kPreempted, too; and
  /// `error` unless the status is kOk.
  Status wait(google::protobuf::Message& result, bool& has_result, std::chrono::nanoseconds timeout,
              std::string& error) const {
    return wait_core(result, has_result, timeout, error);
  }
};

/// An action client for message types that are known at run time only; see ActionClient.
class RawActionClient : public ActionClientBase {
 public:
  RawActionClient() = default;
  explicit RawActionClient(std::shared_ptr<ActionClientCore> core)
      : ActionClientBase(std::move(core)) {}

  /// `on_feedback` gets each feedback message encoded, among the node's callbacks or in wait().
  RawGoalHandle send(const google::protobuf::Message& goal,
                     std::function<void(const std::string& bytes)> on_feedback) const {
    return RawGoalHandle(send_core(goal, std::move(on_feedback)));
  }
};

}  // namespace prehend::graph
