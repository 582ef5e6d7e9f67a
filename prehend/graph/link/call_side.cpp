#include "prehend/graph/link/call_side.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace prehend::graph {
namespace {

using msgs::graph::PeerMessage;

constexpr std::size_t kMostRequestsWaiting = 1000;

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

void PendingCall::finish(Status end_status, std::string text, std::string content) {
  const std::lock_guard lock(mutex);
  if (done) return;
  done = true;
  status = end_status;
  error = std::move(text);
  answer = std::move(content);
  changed.notify_all();
}

void CallSide::start(const std::shared_ptr<PendingCall>& call) {
  if (stopped_) return call->finish(Status::kShutdown, call->offer.label() + ": this node stops");
  if (!advance(*call)) calls_[call->id] = call;
}

// True when the call is over.
bool CallSide::advance(PendingCall& call) {
  if (!call.server.empty()) return false;
  const FoundOffer found = find_offer(registry_, call.offer);
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
    call = advance(*call->second) ? calls_.erase(call) : std::next(call);
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
    call = calls_.erase(call);
  }
}

void CallSide::take_answer(PeerMessage::Answer& answer) {
  const auto call = calls_.find(answer.id());
  if (call == calls_.end()) return;  // came too late
  if (answer.error().empty()) {
    call->second->finish(Status::kOk, "", std::move(*answer.mutable_body()));
  } else {
    call->second->finish(Status::kFailed,
                         call->second->offer.label() + " failed: " + answer.error());
  }
  calls_.erase(call);
}

void CallSide::stop() {
  stopped_ = true;
  for (const auto& [id, call] : calls_) {
    call->finish(Status::kShutdown, call->offer.label() + ": this node stops");
  }
  calls_.clear();
}

Status ServiceClientCore::call(std::string body, bool only_wait, std::chrono::nanoseconds timeout,
                               std::string& answer, std::string& error) {
  const auto deadline = deadline_after(timeout);
  auto call = std::make_shared<PendingCall>();
  call->id = next_call_id();
  call->offer = offer_;
  call->only_wait = only_wait;
  call->body = std::move(body);
  if (!link_->loop->post([call, &side = side_] { side.start(call); })) {
    error = offer_.label() + ": this node has stopped";
    return Status::kShutdown;
  }
  std::unique_lock lock(call->mutex);
  if (call->changed.wait_until(lock, deadline, [&] { return call->done; })) {
    answer = std::move(call->answer);
    error = call->error;
    return call->status;
  }
  const double waited = std::chrono::duration<double>(timeout).count();
  error = call->server_name.empty()
              ? fmt::format("{}: nobody serves it (waited {:.3g} s)", offer_.label(), waited)
              : fmt::format("{}: node '{}' did not answer within {:.3g} s", offer_.label(),
                            call->server_name, waited);
  lock.unlock();
  link_->loop->post([id = call->id, &side = side_] { side.forget(id); });
  return Status::kTimeout;
}

bool ServiceClientBase::wait_for_server(std::chrono::nanoseconds timeout) const {
  std::string answer, error;
  return checked(core_)->call("", true, timeout, answer, error) == Status::kOk;
}

const std::string& ServiceClientBase::service() const { return checked(core_)->offer().name; }

Status ServiceClientBase::call_core(const google::protobuf::Message& request,
                                    google::protobuf::Message& response,
                                    std::chrono::nanoseconds timeout, std::string& error) const {
  std::string answer;
  const Status status =
      checked(core_)->call(request.SerializeAsString(), false, timeout, answer, error);
  if (status != Status::kOk || response.ParseFromString(answer)) return status;
  error = core_->offer().label() + ": the answer is damaged";
  return Status::kFailed;
}

}  // namespace prehend::graph
