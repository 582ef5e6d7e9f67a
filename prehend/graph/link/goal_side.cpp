#include "prehend/graph/link/goal_side.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "prehend/graph/link/callback_scope.h"

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
                   std::string goal_body, OnFeedback on_feedback, const GoalOptions& goal_options)
    : CallbackSource("feedback of " + offer.label()),
      body(std::move(goal_body)),
      options(goal_options),
      deadline(deadline_after(goal_options.timeout)),
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
    if (feedback_stopped_) return;
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

void GoalCore::stop_feedback() {
  const std::lock_guard lock(mutex_);
  feedback_stopped_ = true;
  feedback_.clear();
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

void GoalCore::finish(Status status, std::string error, std::optional<std::string> result) {
  std::uint64_t dropped = 0;
  std::vector<OnEnd> callbacks;
  {
    const std::lock_guard lock(mutex_);
    if (done_) return;
    done_ = true;
    end_ = {status, std::move(error), std::move(result)};
    dropped = feedback_dropped_;
    callbacks.swap(on_end_);
    changed_.notify_all();
  }
  for (OnEnd& callback : callbacks) schedule_end(std::move(callback));
  if (dropped > 0) {
    link_->log(LogLevel::kWarning, fmt::format("{}: {} feedback messages dropped, as this node's "
                                               "callback is slower than they come",
                                               offer_.label(), dropped));
  }
}

void GoalCore::on_end(OnEnd callback) {
  {
    const std::lock_guard lock(mutex_);
    if (!done_) return on_end_.push_back(std::move(callback));
  }
  schedule_end(std::move(callback));
}

void GoalCore::schedule_end(OnEnd callback) {
  link_->executor->schedule("result of " + offer_.label(),
                            [goal = shared_from_this(), callback = std::move(callback)] {
                              goal->deliver_feedback();
                              callback(goal->end_);  // constant once done
                            });
}

void GoalCore::deliver_feedback() {
  while (link_->executor->run_now(*this)) {
  }
}

GoalEnd GoalCore::wait(std::chrono::nanoseconds timeout) {
  const bool in_callback = CallbackScope::source_of(*link_->clock) != nullptr;
  if (in_callback && timeout.count() > 0) {
    return {Status::kRefused,
            refuse_blocking(*link_->clock, offer_.label() + ": wait",
                            "use on_result, or wait in a thread of your own"),
            std::nullopt};
  }
  const auto until = deadline_after(timeout);
  while (true) {
    if (!in_callback) deliver_feedback();
    std::unique_lock lock(mutex_);
    // Others deliver what waits then: the callback thread, or another waiter that is just at one.
    const auto has_feedback = [&] { return !feedback_.empty() && !is_closed() && !in_callback; };
    if (done_ && !has_feedback()) return end_;
    if (const auto now = std::chrono::steady_clock::now(); now < until) {
      if (has_feedback()) {
        changed_.wait_until(lock, std::min(until, now + std::chrono::milliseconds(2)));
      } else {
        changed_.wait_until(lock, until, [&] { return done_ || has_feedback(); });
      }
      continue;
    }
    // This thread may have taken the turn of feedback that came meanwhile.
    for (std::size_t i = 0; i < feedback_.size(); ++i) {
      link_->executor->schedule(shared_from_this());
    }
    return {Status::kTimeout,
            fmt::format("{}: no result yet (waited {:.3g} s)", offer_.label(),
                        std::chrono::duration<double>(timeout).count()),
            std::nullopt};
  }
}

void GoalSide::start(const std::shared_ptr<GoalCore>& goal) {
  if (stopped_) return goal->finish(Status::kShutdown, goal->offer().label() + ": this node stops");
  goal->since = std::chrono::steady_clock::now();
  if (advance(*goal)) return;
  goals_[goal->id()] = goal;
  if (goal->options.timeout.count() == 0) return;
  goal->alarm = loop_.at(goal->deadline, [this, id = goal->id()] { expire(id); });
}

GoalSide::Goals::iterator GoalSide::erase(Goals::iterator goal) {
  if (goal->second->alarm) loop_.cancel(*goal->second->alarm);
  return goals_.erase(goal);
}

void GoalSide::expire(std::uint64_t id) {
  const auto found = goals_.find(id);
  if (found == goals_.end()) return;
  const auto goal = found->second;
  erase(found);
  goal->stop_feedback();
  const double allowed = std::chrono::duration<double>(goal->options.timeout).count();
  if (goal->server.empty()) {
    return goal->finish(Status::kTimeout, fmt::format("{}: nobody serves it (waited {:.3g} s)",
                                                      goal->offer().label(), allowed));
  }
  send_cancel(*goal);
  goal->finish(Status::kTimeout, fmt::format("{}: not done within {:.3g} s, so it was cancelled",
                                             goal->offer().label(), allowed));
}

// True when the goal is over.
bool GoalSide::advance(GoalCore& goal) {
  if (!goal.server.empty()) return false;
  const FoundOffer found = find_offer(registry_, channels_, goal.offer());
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
  goal.since = std::chrono::steady_clock::now();
  if (channels_.send_to_server(goal.server, message)) return false;
  goal.finish(Status::kFailed, fmt::format("{}: the connection to node '{}' is congested",
                                           goal.offer().label(), found.node->name()));
  return true;
}

void GoalSide::send_cancel(const GoalCore& goal) {
  PeerMessage message;
  message.mutable_cancel()->set_id(goal.id());
  message.mutable_cancel()->set_action(goal.offer().name);
  channels_.send_to_server(goal.server, message);
}

void GoalSide::cancel(std::uint64_t id) {
  const auto found = goals_.find(id);
  if (found == goals_.end()) return;
  GoalCore& goal = *found->second;
  if (!goal.server.empty()) return send_cancel(goal);
  goal.finish(Status::kCancelled, goal.offer().label() + ": cancelled before anybody served it");
  erase(found);
}

void GoalSide::look_again() {
  for (auto goal = goals_.begin(); goal != goals_.end();) {
    goal = advance(*goal->second) ? erase(goal) : std::next(goal);
  }
}

void GoalSide::lose_server(const std::string& server) {
  for (auto goal = goals_.begin(); goal != goals_.end();) {
    if (goal->second->server != server) {
      ++goal;
      continue;
    }
    send_cancel(*goal->second);  // reaches a server that lives on behind a broken connection
    goal->second->finish(Status::kServerGone,
                         fmt::format("{}: its server ended before the goal was done ({})",
                                     goal->second->offer().label(), server));
    goal = erase(goal);
  }
}

void GoalSide::check_connections() {
  const auto before = std::chrono::steady_clock::now() - kConnectTime;
  for (auto goal = goals_.begin(); goal != goals_.end();) {
    GoalCore& core = *goal->second;
    std::string lost;
    if (core.server.empty()) {
      lost = find_offer(registry_, channels_, core.offer()).lost;
    } else if (!channels_.is_connected(core.server)) {
      lost = core.server;
    }
    if (lost.empty() || core.since > before) {
      ++goal;
      continue;
    }
    core.finish(Status::kServerGone,
                fmt::format("{}: its server cannot be reached ({})", core.offer().label(), lost));
    goal = erase(goal);
  }
}

void GoalSide::take_feedback(const std::string& server, PeerMessage::Feedback& feedback) {
  const auto goal = goals_.find(feedback.id());
  if (goal == goals_.end() || goal->second->server != server) return;
  goal->second->push_feedback(std::move(*feedback.mutable_body()));
}

void GoalSide::take_result(const std::string& server, PeerMessage::GoalResult& result) {
  const auto goal = goals_.find(result.id());
  if (goal == goals_.end() || goal->second->server != server) return;
  std::optional<std::string> body;
  if (result.has_body()) body = std::move(*result.mutable_body());
  goal->second->finish(to_status(result.status()), result.error(), std::move(body));
  erase(goal);
}

void GoalSide::stop() {
  stopped_ = true;
  for (const auto& [id, goal] : goals_) {
    if (!goal->server.empty()) send_cancel(*goal);
    goal->finish(Status::kShutdown, goal->offer().label() + ": this node stops");
  }
  goals_.clear();
}

std::shared_ptr<GoalCore> ActionClientCore::send(std::string body, GoalCore::OnFeedback on_feedback,
                                                 const GoalOptions& options) {
  if (options.timeout.count() < 0) {
    throw std::invalid_argument(offer_.label() + ": the goal's timeout must not be negative");
  }
  auto goal = std::make_shared<GoalCore>(link_, side_, offer_, std::move(body),
                                         std::move(on_feedback), options);
  if (!link_->loop->post([goal, &side = side_] { side.start(goal); })) {
    goal->finish(Status::kShutdown, offer_.label() + ": this node has stopped");
  }
  return goal;
}

bool GoalHandleBase::done() const { return checked(goal_)->done(); }
void GoalHandleBase::cancel() const { checked(goal_)->cancel(); }

Status GoalHandleBase::wait_core(google::protobuf::Message& result, bool& has_result,
                                 std::chrono::nanoseconds timeout, std::string& error) const {
  const auto goal = checked(goal_);
  GoalEnd end = goal->wait(timeout);
  error = std::move(end.error);
  has_result = end.result && result.ParseFromString(*end.result);
  if (!end.result || has_result) return end.status;
  error = goal->offer().label() + ": the result is damaged";
  return Status::kFailed;
}

void GoalHandleBase::on_end_core(
    std::function<void(Status, const std::string& error, const std::string* result)> callback)
    const {
  checked(goal_)->on_end([callback = std::move(callback)](const GoalEnd& end) {
    callback(end.status, end.error, end.result ? &*end.result : nullptr);
  });
}

bool ActionClientBase::wait_for_server(std::chrono::nanoseconds timeout) const {
  return checked(core_)->waiter().wait_for_server(timeout);
}

const std::string& ActionClientBase::action() const { return checked(core_)->offer().name; }

std::shared_ptr<GoalCore> ActionClientBase::send_core(const google::protobuf::Message& goal,
                                                      RawFeedback on_feedback,
                                                      const GoalOptions& options) const {
  return checked(core_)->send(goal.SerializeAsString(), std::move(on_feedback), options);
}

}  // namespace prehend::graph
