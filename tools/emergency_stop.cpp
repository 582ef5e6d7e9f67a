#include "tools/emergency_stop.h"

#include <utility>

namespace prehend::tools {
namespace {

std::string words_of(const graph::Outcome<msgs::Acknowledge>& outcome) {
  if (!outcome) {
    if (outcome.status() != graph::Status::kTimeout) return outcome.error();
    return outcome.error() + "; is there a node emergency_stop? See prehend node list";
  }
  if (outcome->success()) return "";
  return outcome->reason().empty() ? "refused without a reason" : outcome->reason();
}

}  // namespace

EmergencyStop::EmergencyStop(graph::Node& node, std::string source)
    : source_(std::move(source)),
      stop_(node.client<msgs::EmergencyStopRequest, msgs::Acknowledge>("/emergency_stop/stop")),
      reset_(node.client<msgs::Empty, msgs::Acknowledge>("/emergency_stop/reset")) {}

bool EmergencyStop::is_there() const { return stop_.wait_for_server(std::chrono::seconds(0)); }

std::string EmergencyStop::stop(const std::string& reason,
                                std::chrono::nanoseconds patience) const {
  msgs::EmergencyStopRequest request;
  request.set_source(source_);
  request.set_reason(reason);
  return words_of(stop_.call(request, patience));
}

std::string EmergencyStop::reset(std::chrono::nanoseconds patience) const {
  return words_of(reset_.call({}, patience));
}

}  // namespace prehend::tools
