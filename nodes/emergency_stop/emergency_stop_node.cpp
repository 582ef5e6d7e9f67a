#include "nodes/emergency_stop/emergency_stop_node.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace prehend::nodes {
namespace {

using std::chrono::steady_clock;

constexpr auto kGrace = std::chrono::seconds(10);

// "left_" of a node left_emergency_stop, as a launch names the nodes of a namespace.
std::string prefix_of(const std::string& name) {
  constexpr std::string_view kName = "emergency_stop";
  return name.size() > kName.size() && name.ends_with(kName)
             ? name.substr(0, name.size() - kName.size())
             : "";
}

std::int64_t wall_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

msgs::Acknowledge answer(bool success, const std::string& reason) {
  msgs::Acknowledge message;
  message.set_success(success);
  message.set_reason(reason);
  return message;
}

}  // namespace

EmergencyStopNode::EmergencyStopNode(graph::Node& node, const std::vector<std::string>& required,
                                     const std::string& registry)
    : node_(node),
      required_(required, prefix_of(node.name()), registry),
      publisher_(node.advertise<msgs::EmergencyStop>("/emergency_stop", graph::QoS::latched(1))),
      stop_(node.serve<msgs::EmergencyStopRequest, msgs::Acknowledge>(
          "/emergency_stop/stop",
          [this](const msgs::EmergencyStopRequest& request) { return stop(request); })),
      reset_(node.serve<msgs::Empty, msgs::Acknowledge>(
          "/emergency_stop/reset", [this](const msgs::Empty&) { return reset(); })) {
  thread_ = std::thread([this] { work(); });
}

EmergencyStopNode::~EmergencyStopNode() {
  ends_ = true;
  thread_.join();
}

msgs::Acknowledge EmergencyStopNode::stop(const msgs::EmergencyStopRequest& request) {
  const std::lock_guard lock(mutex_);
  const bool was_stopped = state_.message().stopped();
  if (state_.stop(request, steady_clock::now(), wall_time())) {
    tell();
    if (was_stopped) {
      node_.log_warning("stopped already, and again by {}: {}", request.source(), request.reason());
    }
    report();
  }
  return answer(true, was_stopped
                          ? fmt::format("stopped already, by {}: {}", state_.message().source(),
                                        state_.message().reason())
                          : "all motion is stopped until it is reset");
}

msgs::Acknowledge EmergencyStopNode::reset() {
  if (const std::string away = required_.away(); !away.empty()) {
    return answer(false, fmt::format("what caused it goes on: {} is required, and was lost; start "
                                     "it again",
                                     away));
  }
  const std::lock_guard lock(mutex_);
  if (!state_.message().stopped()) return answer(true, "nothing was stopped");
  if (const std::string causes = state_.reset(steady_clock::now()); !causes.empty()) {
    return answer(false, causes);
  }
  tell();
  node_.log_info("reset: motion is allowed again");
  return answer(true, "motion is allowed again");
}

void EmergencyStopNode::tell() { publisher_.publish(state_.message()); }

void EmergencyStopNode::work() {
  auto next = steady_clock::now();
  while (!ends_ && node_.ok()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - steady_clock::now());
    const auto losses = required_.wait_for_losses(std::max(left, std::chrono::milliseconds(0)));
    for (const RequiredNodes::Loss& loss : losses) {
      msgs::EmergencyStopRequest request;
      request.set_source(node_.name());
      request.set_reason(fmt::format("required node {} was lost: {}", loss.node, loss.reason));
      stop(request);
    }
    if (steady_clock::now() < next) continue;
    next = steady_clock::now() + kPeriod;
    const std::lock_guard lock(mutex_);
    tell();
    report();
  }
}

void EmergencyStopNode::report() {
  const msgs::EmergencyStop& state = state_.message();
  // At a start the others may come a little later.
  const bool is_early = steady_clock::now() - began_ < kGrace;
  const std::string missing = is_early ? "" : required_.missing();
  std::string words = "motion is allowed";
  if (state.stopped()) {
    words = fmt::format("all motion is stopped by {}: {}. Then: prehend stop --reset",
                        state.source(), state.reason());
  } else if (!missing.empty()) {
    words = "required, and never seen: " + missing;
  }
  if (words == std::exchange(reported_, words)) return;
  node_.report(state.stopped() || !missing.empty() ? graph::Health::kWarning : graph::Health::kOk,
               words);
}

}  // namespace prehend::nodes
