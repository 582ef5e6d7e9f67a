#include "nodes/emergency_stop_listener/emergency_stop_listener.h"

#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace prehend::nodes {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr auto kLook = 20ms;
constexpr auto kAskAgain = 200ms;  // a node that does not know of the stop
constexpr auto kPatience = 1s;     // for its answer

constexpr std::string_view kStopped = "emergency stop";
constexpr std::string_view kBy = " by ";

std::string words_of(const msgs::EmergencyStop& message) {
  return fmt::format("{}{}{}{}{}", kStopped, kBy, message.source(),
                     message.reason().empty() ? "" : ": ", message.reason());
}

// What is told again, without the words that will be put before it.
std::string reason_of(std::string words) {
  for (const std::string& before :
       {std::string(kStopped) + std::string(kBy), std::string(kStopped) + ": "}) {
    if (words.starts_with(before)) return words.substr(before.size());
  }
  return words;
}

}  // namespace

EmergencyStopListener::EmergencyStopListener(graph::Node& node, bool is_minded,
                                             std::chrono::milliseconds silence)
    : node_(node), silence_(silence) {
  if (!is_minded) return;
  ask_ = node.client<msgs::EmergencyStopRequest, msgs::Acknowledge>("/emergency_stop/stop");
  subscription_ = node.subscribe<msgs::EmergencyStop>(
      "/emergency_stop", graph::QoS::latched(50),
      [this](const graph::Received<msgs::EmergencyStop>& message) { take(*message); });
}

EmergencyStopListener::~EmergencyStopListener() {
  subscription_ = {};
  {
    const std::lock_guard lock(end_mutex_);
    ends_ = true;
  }
  end_.notify_all();
  if (watch_.joinable()) watch_.join();
}

std::string EmergencyStopListener::refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

EmergencyStopListener::Action& EmergencyStopListener::Action::operator=(Action&& other) noexcept {
  if (this == &other) return *this;
  end();
  listener_ = std::exchange(other.listener_, nullptr);
  place_ = other.place_;
  return *this;
}

void EmergencyStopListener::Action::end() {
  if (!listener_) return;
  const std::lock_guard lock(listener_->actions_mutex_);
  listener_->actions_.erase(place_);
  listener_ = nullptr;
}

EmergencyStopListener::Action EmergencyStopListener::on_stop(Action::Stop stop) {
  Action action;
  const std::lock_guard lock(actions_mutex_);
  action.listener_ = this;
  action.place_ = actions_.insert(actions_.end(), std::move(stop));
  return action;
}

void EmergencyStopListener::take(const msgs::EmergencyStop& message) {
  std::string stops, ends;
  bool asks = false;
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(heard_, true)) {
      count_ = message.count();
      watch_ = std::thread([this] { watch(); });
      if (message.stopped()) stops = words_of(message);
    } else if (message.stopped()) {
      if (refusal_.empty() || message.count() != count_) stops = words_of(message);
    } else if (message.count() > count_ && refusal_.empty()) {
      // Stopped and reset before this was told of either.
      stops = std::string(kStopped) + ", which was reset already";
    } else if (!refusal_.empty()) {
      // A node that was started anew counts from 0: it knows of no stop.
      const bool is_reset = is_told_ && message.count() >= count_;
      if (is_reset) {
        ends = std::exchange(refusal_, {});
      } else {
        asks = steady_clock::now() - asked_ > kAskAgain;
      }
    }
    silent_looks_ = 0;
    if (message.stopped()) {
      refusal_ = words_of(message);
      is_told_ = true;
    }
    if (message.stopped() || refusal_.empty()) count_ = message.count();
    if (asks) asked_ = steady_clock::now();
  }
  if (!stops.empty()) stop(stops);
  if (!ends.empty()) node_.log_info("motion is allowed again: the emergency stop was reset");
  if (asks) ask(reason_of(refusal()), false);
}

void EmergencyStopListener::stop(const std::string& why) {
  {
    const std::lock_guard lock(actions_mutex_);
    for (const Action::Stop& action : actions_)
      node_.shield("emergency stop", [&] { action(why); });
  }
  node_.log_warning("{}", why);
}

void EmergencyStopListener::ask(const std::string& reason, bool persists) {
  msgs::EmergencyStopRequest request;
  request.set_source(node_.name());
  request.set_reason(reason);
  request.set_persists(persists);
  // Without an answer it is asked again: by the next message that knows of no stop.
  ask_.call_async(request, kPatience, [](const graph::Outcome<msgs::Acknowledge>&) {});
}

void EmergencyStopListener::tell_device(const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    if (!heard_) return;  // nobody to be told
  }
  if (!problem.empty()) ask(problem, true);
}

void EmergencyStopListener::watch() {
  std::unique_lock lock(end_mutex_);
  while (!end_.wait_for(lock, kLook, [this] { return ends_; })) {
    lock.unlock();
    look();
    lock.lock();
  }
}

void EmergencyStopListener::look() {
  std::string stops;
  {
    const std::lock_guard lock(mutex_);
    silent_looks_ = waits_ > 0 ? 0 : silent_looks_ + 1;
    if (silent_looks_ != silence_ / kLook || !node_.ok()) return;
    // Also where it was stopped: the one that knew why is gone, and its successor will not.
    const bool is_new = refusal_.empty();
    if (is_new) {
      refusal_ = stops = fmt::format("{}: the node emergency_stop was not heard for {} s", kStopped,
                                     static_cast<double>(silence_.count()) * 1e-3);
    }
    is_told_ = false;
  }
  if (!stops.empty()) stop(stops);
}

}  // namespace prehend::nodes
