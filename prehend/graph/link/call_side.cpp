#include "prehend/graph/link/call_side.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <vector>

#include "prehend/graph/link/callback_scope.h"

namespace prehend::graph {
namespace {

using msgs::graph::PeerMessage;

constexpr std::size_t kMostRequestsWaiting = 1000;
constexpr std::chrono::seconds kLook{
    1};  // at most, for the node's thread to see whether there is a server

std::uint64_t next_call_id() {
  static std::atomic<std::uint64_t> next{1};
  return next++;
}

const std::shared_ptr<ServiceClientCore>& checked(const std::shared_ptr<ServiceClientCore>& core) {
  if (!core) throw std::logic_error("this service client was not made by Node::client");
  return core;
}

}  // namespace

ServiceCore::ServiceCore(std::shared_ptr<NodeLink> link, OfferType offer, Handler handler)
    : CallbackSource(offer.label()),
      link_(std::move(link)),
      offer_(std::move(offer)),
      handler_(std::move(handler)) {}

void ServiceCore::push(const std::string& client, PeerMessage::Call call) {
  Request request{client, call.id(), std::move(*call.mutable_body())};
  if (call.request_hash() != offer_.type_hashes[0]) {
    return answer_error(request, offer_.label() + ": the request is of another message type");
  }
  {
    const std::lock_guard lock(mutex_);
    if (queue_.size() >= kMostRequestsWaiting) {
      return answer_error(
          request, fmt::format("{}: {} requests wait already", offer_.label(), queue_.size()));
    }
    queue_.push_back(std::move(request));
  }
  link_->executor->schedule(shared_from_this());
}

bool ServiceCore::run_one() {
  Request request;
  {
    const std::lock_guard lock(mutex_);
    if (queue_.empty()) return false;
    request = std::move(queue_.front());
    queue_.pop_front();
  }
  PeerMessage message;
  message.mutable_answer()->set_id(request.id);
  try {
    message.mutable_answer()->set_body(handler_(request.body));
  } catch (const std::exception& error) {
    answer_error(request, error.what());
    throw;  // the server's own log has it, too
  } catch (...) {
    answer_error(request, kForeignException);
    throw;
  }
  link_->send_to_client(request.client, message);
  return true;
}

void ServiceCore::answer_error(const Request& request, const std::string& error) {
  PeerMessage message;
  message.mutable_answer()->set_id(request.id);
  message.mutable_answer()->set_error(error.empty() ? "failed without a reason" : error);
  link_->send_to_client(request.client, message);
}

void ServiceCore::withdraw() {
  close();
  std::deque<Request> left;
  {
    const std::lock_guard lock(mutex_);
    left.swap(queue_);
  }
  for (const Request& request : left) answer_error(request, offer_.label() + " was withdrawn");
  if (!withdraw_) return;
  link_->names.release("service", offer_.name);
  link_->loop->post(std::exchange(withdraw_, nullptr));
}

Service::Service(std::shared_ptr<ServiceCore> core) : core_(std::move(core)) {}
Service::~Service() {
  if (core_) core_->withdraw();
}
Service::Service(Service&&) noexcept = default;
Service& Service::operator=(Service&& other) noexcept {
  if (this != &other) {
    if (core_) core_->withdraw();
    core_ = std::move(other.core_);
  }
  return *this;
}

void PendingCall::finish(Status status, std::string error, std::string answer) {
  {
    const std::lock_guard lock(mutex);
    if (done) return;
    done = true;
    end = {status, std::move(error), std::move(answer)};
    changed.notify_all();
  }
  if (on_end) on_end(end);
}

std::string PendingCall::timeout_error() const {
  const double waited = std::chrono::duration<double>(timeout).count();
  return server_name.empty()
             ? fmt::format("{}: nobody serves it (waited {:.3g} s)", offer.label(), waited)
             : fmt::format("{}: node '{}' did not answer within {:.3g} s", offer.label(),
                           server_name, waited);
}

void CallSide::start(const std::shared_ptr<PendingCall>& call) {
  if (stopped_) return call->finish(Status::kShutdown, call->offer.label() + ": this node stops");
  call->since = std::chrono::steady_clock::now();
  if (advance(*call)) return;
  if (call->only_wait && call->timeout.count() == 0) {
    return call->finish(Status::kTimeout, call->timeout_error());  // it was a look
  }
  calls_[call->id] = call;
  if (call->on_end) call->alarm = loop_.at(call->deadline, [this, id = call->id] { expire(id); });
}

CallSide::Calls::iterator CallSide::erase(Calls::iterator call) {
  if (call->second->alarm) loop_.cancel(*call->second->alarm);
  return calls_.erase(call);
}

void CallSide::forget(std::uint64_t id) {
  if (const auto call = calls_.find(id); call != calls_.end()) erase(call);
}

void CallSide::expire(std::uint64_t id) {
  const auto found = calls_.find(id);
  if (found == calls_.end()) return;
  const auto call = found->second;
  erase(found);
  std::string error;
  {
    const std::lock_guard lock(call->mutex);
    error = call->timeout_error();
  }
  call->finish(Status::kTimeout, error);
}

// True when the call is over.
bool CallSide::advance(PendingCall& call) {
  if (!call.server.empty()) return false;
  const FoundOffer found = find_offer(registry_, channels_, call.offer);
  if (!found.node) return false;
  if (!found.error.empty()) {
    call.finish(Status::kFailed, found.error);
    return true;
  }
  if (call.only_wait) {
    call.finish(Status::kOk, "");
    return true;
  }
  channels_.connect(found.node->instance(), found.node->endpoint());
  PeerMessage message;
  auto& request = *message.mutable_call();
  request.set_id(call.id);
  request.set_service(call.offer.name);
  request.set_request_hash(call.offer.type_hashes[0]);
  request.set_body(std::move(call.body));
  call.server = found.node->instance();
  call.since = std::chrono::steady_clock::now();
  {
    const std::lock_guard lock(call.mutex);
    call.server_name = found.node->name();
  }
  if (channels_.send_to_server(call.server, message)) return false;
  call.finish(Status::kFailed, fmt::format("{}: the connection to node '{}' is congested",
                                           call.offer.label(), found.node->name()));
  return true;
}

void CallSide::look_again() {
  for (auto call = calls_.begin(); call != calls_.end();) {
    call = advance(*call->second) ? erase(call) : std::next(call);
  }
}

void CallSide::lose_server(const std::string& server) {
  for (auto call = calls_.begin(); call != calls_.end();) {
    if (call->second->server != server) {
      ++call;
      continue;
    }
    call->second->finish(Status::kServerGone,
                         fmt::format("{}: its server ended before it answered ({})",
                                     call->second->offer.label(), server));
    call = erase(call);
  }
}

void CallSide::check_connections() {
  const auto before = std::chrono::steady_clock::now() - kConnectTime;
  for (auto call = calls_.begin(); call != calls_.end();) {
    const PendingCall& pending = *call->second;
    std::string lost;
    if (pending.server.empty()) {
      lost = find_offer(registry_, channels_, pending.offer).lost;
    } else if (!channels_.is_connected(pending.server)) {
      lost = pending.server;
    }
    if (lost.empty() || pending.since > before || pending.only_wait) {
      ++call;
      continue;
    }
    call->second->finish(Status::kServerGone, fmt::format("{}: its server cannot be reached ({})",
                                                          pending.offer.label(), lost));
    call = erase(call);
  }
}

void CallSide::take_answer(const std::string& server, PeerMessage::Answer& answer) {
  const auto call = calls_.find(answer.id());
  if (call == calls_.end() || call->second->server != server) return;  // came too late
  if (answer.error().empty()) {
    call->second->finish(Status::kOk, "", std::move(*answer.mutable_body()));
  } else {
    call->second->finish(Status::kFailed,
                         call->second->offer.label() + " failed: " + answer.error());
  }
  erase(call);
}

void CallSide::stop() {
  stopped_ = true;
  for (const auto& [id, call] : calls_) {
    call->finish(Status::kShutdown, call->offer.label() + ": this node stops");
  }
  calls_.clear();
}

std::shared_ptr<PendingCall> ServiceClientCore::make_call(std::string body,
                                                          std::chrono::nanoseconds timeout) const {
  auto call = std::make_shared<PendingCall>();
  call->id = next_call_id();
  call->offer = offer_;
  call->body = std::move(body);
  call->timeout = timeout;
  call->deadline = deadline_after(timeout);
  return call;
}

bool ServiceClientCore::post(const std::shared_ptr<PendingCall>& call) {
  if (link_->loop->post([call, &side = side_] { side.start(call); })) return true;
  call->finish(Status::kShutdown, offer_.label() + ": this node has stopped");
  return false;
}

CallEnd ServiceClientCore::run(const std::shared_ptr<PendingCall>& call) {
  post(call);
  // Who looks whether there is a server waits until the node's thread has looked, which is at once.
  const bool looks = call->only_wait && call->timeout.count() == 0;
  const auto until = looks ? deadline_after(kLook) : call->deadline;
  std::unique_lock lock(call->mutex);
  if (call->changed.wait_until(lock, until, [&] { return call->done; })) {
    return std::move(call->end);
  }
  const std::string error = call->timeout_error();
  lock.unlock();
  link_->loop->post([id = call->id, &side = side_] { side.forget(id); });
  return {Status::kTimeout, error, ""};
}

CallEnd ServiceClientCore::call(std::string body, std::chrono::nanoseconds timeout) {
  if (timeout.count() > 0) {
    const std::string refused = refuse_blocking(*link_->clock, offer_.label() + ": call",
                                                "use call_async, or call in a thread of your own");
    if (!refused.empty()) return {Status::kRefused, refused, ""};
  }
  return run(make_call(std::move(body), timeout));
}

void ServiceClientCore::call_async(std::string body, std::chrono::nanoseconds timeout,
                                   std::function<void(CallEnd)> on_end) {
  const auto call = make_call(std::move(body), timeout);
  call->on_end = [link = std::weak_ptr(link_), name = "answer of " + offer_.label(),
                  on_end = std::move(on_end)](CallEnd end) {
    const auto alive = link.lock();
    if (!alive) return;
    alive->executor->schedule(name,
                              [on_end, end = std::move(end)]() mutable { on_end(std::move(end)); });
  };
  post(call);
}

bool ServiceClientCore::wait_for_server(std::chrono::nanoseconds timeout) {
  if (timeout.count() > 0) {
    const std::string refused = refuse_blocking(
        *link_->clock, offer_.label() + ": wait_for_server",
        "a call or a goal waits for its server by itself, or wait in a thread of your own");
    if (!refused.empty()) throw std::logic_error(refused);
  }
  const auto call = make_call("", timeout);
  call->only_wait = true;
  return run(call).status == Status::kOk;
}

bool ServiceClientBase::wait_for_server(std::chrono::nanoseconds timeout) const {
  return checked(core_)->wait_for_server(timeout);
}

const std::string& ServiceClientBase::service() const { return checked(core_)->offer().name; }

Status ServiceClientBase::call_core(const google::protobuf::Message& request,
                                    google::protobuf::Message& response,
                                    std::chrono::nanoseconds timeout, std::string& error) const {
  CallEnd end = checked(core_)->call(request.SerializeAsString(), timeout);
  error = std::move(end.error);
  if (end.status != Status::kOk || response.ParseFromString(end.answer)) return end.status;
  error = core_->offer().label() + ": the answer is damaged";
  return Status::kFailed;
}

void ServiceClientBase::call_async_core(
    const google::protobuf::Message& request, std::chrono::nanoseconds timeout,
    std::function<void(Status, std::string error, const std::string& answer)> on_end) const {
  checked(core_)->call_async(request.SerializeAsString(), timeout,
                             [on_end = std::move(on_end)](CallEnd end) {
                               on_end(end.status, std::move(end.error), end.answer);
                             });
}

}  // namespace prehend::graph
