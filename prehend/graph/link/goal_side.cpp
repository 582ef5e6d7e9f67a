#include "prehend/graph/link/goal_side.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <atomic>
#include <stdexcept>

namespace prehend::graph {
namespace {

using msgs::graph::PeerMessage;

constexpr std::size_t kMostFeedbackWaiting = 1000;

std::uint64_t next_goal_id() {
  static std::atomic<std::uint64_t> next{1};
  return next++;
}

Status to_status(PeerMessage::GoalStatus status) {
  switch (status) {
    case PeerMessage::SUCCEEDED:
      return Status::kOk;
    case PeerMessage::CANCELLED:
      return Status::kCancelled;
    case PeerMessage::PREEMPTED:
      return Status::kPreempted;
    default:
      return Status::kFailed;
  }
}

template <class Core>
const std::shared_ptr<Core>& checked(const std::shared_ptr<Core>& core) {
  if (!core) throw std::logic_error("this action client or goal is empty");
  return core;
}

}  // namespace

GoalCore::GoalCore(std::shared_ptr<NodeLink> link, GoalSide& side, OfferType offer,
                   std::string goal_body, OnFeedback on_feedback)
    : CallbackSource("feedback of " + offer.label()),
      body(std::move(goal_body)),
      link_(std::move(link)),
      side_(side),
      offer_(std::move(offer)),
      id_(next_goal_id()),
      on_feedback_(std::move(on_feedback)) {}

bool GoalCore::done() const {
  const std::lock_guard lock(mutex_);
  return done_;
}

void GoalCore::cancel() {
  close();
  {
    const std::lock_guard lock(mutex_);
    feedback_.clear();
  }
  link_->loop->post([goal = shared_from_this()] { goal->side_.cancel(goal->id_); });
}

void GoalCore::push_feedback(std::string content) {
  if (!on_feedback_ || is_closed()) return;
  bool dropped = false;
  {
    const std::lock_guard lock(mutex_);
    dropped = feedback_.size() >= kMostFeedbackWaiting;
    if (dropped) {
      feedback_.pop_front();
      ++feedback_dropped_;
    }
    feedback_.push_back(std::move(content));
    changed_.notify_all();
  }
  if (!dropped) link_->executor->schedule(shared_from_this());
}

bool GoalCore::run_one() {
  std::string content;
  {
    const std::lock_guard lock(mutex_);
    if (feedback_.empty()) return false;
    content = std::move(feedback_.front());
    feedback_.pop_front();
  }
  on_feedback_(content);
  return true;
}

void GoalCore::finish(Status status, std::string error, bool has_result, std::string result) {
  std::uint64_t dropped = 0;
  {
    const std::lock_guard lock(mutex_);
    if (done_) return;
    done_ = true;
    status_ = status;
    error_ = std::move(error);
    has_result_ = has_result;
    result_ = std::move(result);
    dropped = feedback_dropped_;
    changed_.notify_all();
  }
  if (dropped > 0) {
    link_->log(LogLevel::kWarning, fmt::format("{}: {} feedback messages dropped, as this node's "
                                               "callback is slower than they come",
                                               offer_.label(), dropped));
  }
}

Status GoalCore::wait(std::chrono::nanoseconds timeout, std::string& error, bool& has_result,
                      std::string& result) {
  const auto deadline = deadline_after(timeout);
  while (true) {
    while (link_->executor->run_now(*this)) {
    }
    std::unique_lock lock(mutex_);
    const auto has_feedback = [&] { return !feedback_.empty() && !is_closed(); };
    if (has_feedback()) {  // another thread is just at one
      changed_.wait_for(lock, std::chrono::milliseconds(2));
      continue;
    }
    if (done_) {
      error = error_;
      has_result = has_result_;
      result = result_;
      return status_;
    }
    if (changed_.wait_until(lock, deadline, [&] { return done_ || has_feedback(); })) continue;
    error = fmt::format("{}: no result yet (waited {:.3g} s)", offer_.label(),
                        std::chrono::duration<double>(timeout).count());
    return Status::kTimeout;
  }
}

void GoalSide::start(const std::shared_ptr<GoalCore>& goal) {
  if (stopped_) return goal->finish(Status::kShutdown, goal->offer().label() + ": this node stops");
  if (!advance(*goal)) goals_[goal->id()] = goal;
}

// True when the goal is over.
bool GoalSide::advance(GoalCore& goal) {
  if (!goal.server.empty()) return false;
  const FoundOffer found = find_offer(registry_, goal.offer());
  if (!found.node) return false;
  if (!found.error.empty()) {
    goal.finish(Status::kFailed, found.error);
    return true;
  }
  channels_.connect(found.node->instance(), found.node->endpoint());
  PeerMessage message;
  auto& request = *message.mutable_goal();
  request.set_id(goal.id());
  request.set_action(goal.offer().name);
  request.set_goal_hash(goal.offer().type_hashes[0]);
  request.set_body(std::move(goal.body));
  goal.server = found.node->instance();
  if (channels_.send_to_server(goal.server, message)) return false;
  goal.finish(Status::kFailed, fmt::format("{}: the connection to node '{}' is congested",
                                           goal.offer().label(), found.node->name()));
  return true;
}

void GoalSide::cancel(std::uint64_t id) {
  const auto found = goals_.find(id);
  if (found == goals_.end()) return;
  GoalCore& goal = *found->second;
  if (goal.server.empty()) {
    goal.finish(Status::kCancelled, goal.offer().label() + ": cancelled before anybody served it");
    goals_.erase(found);
    return;
  }
  PeerMessage message;
  message.mutable_cancel()->set_id(id);
  message.mutable_cancel()->set_action(goal.offer().name);
  channels_.send_to_server(goal.server, message);
}

void GoalSide::look_again() {
  for (auto goal = goals_.begin(); goal != goals_.end();) {
    goal = advance(*goal->second) ? goals_.erase(goal) : std::next(goal);
  }
}

void GoalSide::lose_server(const std::string& server) {
  for (auto goal = goals_.begin(); goal != goals_.end();) {
    if (goal->second->server != server) {
      ++goal;
      continue;
    }
    cancel(goal->first);  // reaches a server that lives on behind a broken connection
    goal->second->finish(Status::kServerGone,
                         fmt::format("{}: its server ended before the goal was done ({})",
                                     goal->second->offer().label(), server));
    goal = goals_.erase(goal);
  }
}

void GoalSide::take_feedback(PeerMessage::Feedback& feedback) {
  const auto goal = goals_.find(feedback.id());
  if (goal != goals_.end()) goal->second->push_feedback(std::move(*feedback.mutable_body()));
}

void GoalSide::take_result(PeerMessage::GoalResult& result) {
  const auto goal = goals_.find(result.id());
  if (goal == goals_.end()) return;
  goal->second->finish(to_status(result.status()), result.error(), result.has_body(),
                       std::move(*result.mutable_body()));
  goals_.erase(goal);
}

void GoalSide::stop() {
  stopped_ = true;
  for (const auto& [id, goal] : goals_) {
    if (!goal->server.empty()) cancel(id);
    goal->finish(Status::kShutdown, goal->offer().label() + ": this node stops");
  }
  goals_.clear();
}

std::shared_ptr<GoalCore> ActionClientCore::send(std::string body,
                                                 GoalCore::OnFeedback on_feedback) {
  auto goal =
      std::make_shared<GoalCore>(link_, side_, offer_, std::move(body), std::move(on_feedback));
  if (!link_->loop->post([goal, &side = side_] { side.start(goal); })) {
    goal->finish(Status::kShutdown, offer_.label() + ": this node has stopped");
  }
  return goal;
}

bool GoalHandleBase::done() const { return checked(goal_)->done(); }
void GoalHandleBase::cancel() const { checked(goal_)->cancel(); }

Status GoalHandleBase::wait_core(google::protobuf::Message& result, bool& has_result,
                                 std::chrono::nanoseconds timeout, std::string& error) const {
  std::string body;
  const auto goal = checked(goal_);
  const Status status = goal->wait(timeout, error, has_result, body);
  if (!has_result || result.ParseFromString(body)) return status;
  has_result = false;
  error = goal->offer().label() + ": the result is damaged";
  return Status::kFailed;
}

bool ActionClientBase::wait_for_server(std::chrono::nanoseconds timeout) const {
  std::string answer, error;
  return checked(core_)->waiter().call("", true, timeout, answer, error) == Status::kOk;
}

const std::string& ActionClientBase::action() const { return checked(core_)->offer().name; }

std::shared_ptr<GoalCore> ActionClientBase::send_core(const google::protobuf::Message& goal,
                                                      RawFeedback on_feedback) const {
  return checked(core_)->send(goal.SerializeAsString(), std::move(on_feedback));
}

}  // namespace prehend::graph
