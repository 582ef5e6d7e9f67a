#include "prehend/graph/link/action_server_core.h"

#include <google/protobuf/message.h>

#include <chrono>
#include <thread>
#include <utility>

namespace prehend::graph {
namespace {

using msgs::graph::PeerMessage;

constexpr std::size_t kMostFeedbackToSend = 1000;

}  // namespace

ActionServerCore::ActionServerCore(std::shared_ptr<NodeLink> link, OfferType offer, Handler handler)
    : link_(std::move(link)), offer_(std::move(offer)), handler_(std::move(handler)) {}

ActionServerCore::~ActionServerCore() {
  stop();
  if (thread_.joinable()) thread_.detach();  // it runs this destructor as its last deed
}

void ActionServerCore::start() {
  const std::lock_guard lock(thread_mutex_);
  // The thread holds the server, as the handler may destroy the last handle.
  thread_ = std::thread([self = shared_from_this()] { self->work(); });
}

void ActionServerCore::accept(const std::string& client, PeerMessage::Goal goal) {
  auto task = std::make_shared<GoalTask>();
  task->link = link_;
  task->client = client;
  task->id = goal.id();
  task->body = std::move(*goal.mutable_body());
  if (goal.goal_hash() != offer_.type_hashes[0]) {
    return send_end(*task, PeerMessage::FAILED,
                    offer_.label() + ": the goal is of another message type");
  }
  std::shared_ptr<GoalTask> never_run;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) {
      never_run = task;
    } else {
      if (current_ && !current_->cancelled) {  // else its client's cancel is what ends it
        current_->preempted = true;
        current_->cancelled = true;
      }
      never_run = std::exchange(pending_, task);
    }
  }
  link_->clock->wake();
  changed_.notify_all();
  if (!never_run) return;
  if (never_run == task) {
    send_end(*never_run, PeerMessage::FAILED, offer_.label() + " was withdrawn");
  } else {
    send_end(*never_run, PeerMessage::PREEMPTED, offer_.label() + ": another goal took its place");
  }
}

void ActionServerCore::cancel(const std::string& client, std::uint64_t id) {
  cancel_where([&](const GoalTask& task) { return task.client == client && task.id == id; });
}

bool ActionServerCore::cancel_all() {
  return cancel_where([](const GoalTask&) { return true; });
}

void ActionServerCore::lose_client(const std::string& client) {
  cancel_where([&](const GoalTask& task) { return task.client == client; });
}

bool ActionServerCore::cancel_where(const std::function<bool(const GoalTask&)>& applies) {
  std::shared_ptr<GoalTask> never_run;
  bool found = false;
  {
    const std::lock_guard lock(mutex_);
    found = current_ && applies(*current_);
    if (found) current_->cancelled = true;
    if (pending_ && applies(*pending_)) never_run = std::exchange(pending_, nullptr);
  }
  link_->clock->wake();
  if (never_run) {
    send_end(*never_run, PeerMessage::CANCELLED, offer_.label() + ": cancelled before it began");
  }
  return found || never_run;
}

void ActionServerCore::probe_client() {
  constexpr auto kPeriod = std::chrono::milliseconds(500);
  const auto now = std::chrono::steady_clock::now();
  if (now - last_probe_ < kPeriod) return;
  last_probe_ = now;
  PeerMessage message;
  message.mutable_feedback()->set_id(0);
  const std::lock_guard lock(mutex_);
  for (const auto& task : {current_, pending_}) {
    if (task && !task->cancelled) link_->send_to_client(task->client, message);
  }
}

void ActionServerCore::work() {
  thread_id_ = std::this_thread::get_id();
  while (true) {
    std::shared_ptr<GoalTask> task;
    {
      std::unique_lock lock(mutex_);
      current_ = nullptr;
      changed_.wait(lock, [&] { return stopping_ || pending_; });
      if (stopping_) break;
      task = current_ = std::exchange(pending_, nullptr);
    }
    run(*task);
  }
  const std::lock_guard lock(mutex_);
  if (pending_) send_end(*pending_, PeerMessage::FAILED, offer_.label() + " was withdrawn");
  pending_ = nullptr;
}

void ActionServerCore::run(GoalTask& task) {
  try {
    const std::string result = handler_(task.body, task);
    if (task.preempted) {
      send_end(task, PeerMessage::PREEMPTED, offer_.label() + ": another goal took its place",
               &result);
    } else if (task.cancelled) {
      send_end(task, PeerMessage::CANCELLED, offer_.label() + ": cancelled", &result);
    } else {
      send_end(task, PeerMessage::SUCCEEDED, "", &result);
    }
  } catch (const std::exception& error) {
    fail(task, error.what());
  } catch (...) {
    fail(task, kForeignException);
  }
}

void ActionServerCore::fail(const GoalTask& task, const std::string& what) {
  send_end(task, PeerMessage::FAILED, offer_.label() + " failed: " + what);
  link_->callback_failed(offer_.label(), what);
}

void ActionServerCore::send_end(const GoalTask& task, PeerMessage::GoalStatus status,
                                const std::string& error, const std::string* body) {
  PeerMessage message;
  auto& result = *message.mutable_goal_result();
  result.set_id(task.id);
  result.set_status(status);
  result.set_error(error);
  result.set_has_body(body != nullptr);
  if (body) result.set_body(*body);
  link_->send_to_client(task.client, message);
}

void ActionServerCore::begin_stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    if (current_) current_->cancelled = true;
  }
  changed_.notify_all();
  link_->clock->wake();
}

void ActionServerCore::stop() {
  begin_stop();
  if (thread_id_ == std::this_thread::get_id()) return;  // the handler ends its own server
  const std::lock_guard lock(thread_mutex_);
  if (thread_.joinable()) thread_.join();
}

void ActionServerCore::withdraw() {
  stop();
  if (!withdraw_) return;
  link_->names.release("action", offer_.name);
  link_->loop->post(std::exchange(withdraw_, nullptr));
}

ActionServer::ActionServer(std::shared_ptr<ActionServerCore> core) : core_(std::move(core)) {}
ActionServer::~ActionServer() {
  if (core_) core_->withdraw();
}
ActionServer::ActionServer(ActionServer&&) noexcept = default;
ActionServer& ActionServer::operator=(ActionServer&& other) noexcept {
  if (this != &other) {
    if (core_) core_->withdraw();
    core_ = std::move(other.core_);
  }
  return *this;
}

bool ActionContextBase::cancelled() const { return task_->cancelled; }
bool ActionContextBase::preempted() const { return task_->preempted; }

bool ActionContextBase::sleep_for(std::chrono::nanoseconds duration) const {
  return task_->link->clock->sleep_for(duration.count(),
                                       [task = task_] { return task->cancelled.load(); });
}

bool ActionContextBase::sleep_until(std::int64_t stamp) const {
  return task_->link->clock->sleep_until(stamp, [task = task_] { return task->cancelled.load(); });
}

// A handler that does nothing else is faster than the loop that sends: it is held back, or what it
// says would pile up between the two.
void ActionContextBase::send_feedback(const google::protobuf::Message& feedback) const {
  while (task_->link->waiting_to_send > kMostFeedbackToSend && !task_->cancelled) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  PeerMessage message;
  message.mutable_feedback()->set_id(task_->id);
  message.mutable_feedback()->set_body(feedback.SerializeAsString());
  task_->link->send_to_client(task_->client, message);
}

}  // namespace prehend::graph
