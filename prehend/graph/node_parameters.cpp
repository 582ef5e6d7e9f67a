// A node's parameters towards the graph: requests from outside, and word of what was set.

#include <fmt/format.h>

#include "prehend/graph/node_impl.h"

namespace prehend::graph {

using msgs::graph::PeerMessage;

namespace {

constexpr std::size_t kMostSettingsWaiting = 1000;  // for the node's callbacks

}  // namespace

void Node::Impl::announce_parameters() {
  if (describing) return;
  std::call_once(parameters_announced, [this] {
    parameter_events = Publisher<msgs::graph::ParameterEvent>(
        make_publisher("/parameter_events", QoS::queue(100),
                       schema_of(*msgs::graph::ParameterEvent::descriptor())));
  });
}

void Node::Impl::parameters_were_set(const std::vector<ParameterInfo>& changed) {
  if (changed.empty()) return;
  msgs::graph::ParameterEvent event;
  event.set_stamp(link->clock->now());
  event.set_node(options.name);
  for (const ParameterInfo& parameter : changed) {
    log(LogLevel::kInfo,
        fmt::format("parameter {} is now {}", parameter.name, to_text(parameter.value)));
    *event.add_changed() = to_record(parameter);
    if (!parameter.on_change) continue;
    link->executor->schedule("on_change of parameter " + parameter.name,
                             [parameter] { parameter.on_change(parameter.value); });
  }
  if (!describing) parameter_events.publish(event);
}

void Node::Impl::answer_parameters(const std::string& client,
                                   const PeerMessage::ParameterRequest& request) {
  std::map<std::string, std::string> texts;
  for (const auto& setting : request.settings()) texts[setting.name()] = setting.text();
  if (request.has_set_text()) texts[request.name()] = request.set_text();
  if (!texts.empty()) {
    if (!parameters.has_validation(texts)) return set_from_outside(client, request.id(), texts);
    if (settings_waiting < kMostSettingsWaiting) {
      ++settings_waiting;
      return link->executor->schedule("validation of parameters",
                                      [this, client, id = request.id(), texts] {
                                        --settings_waiting;
                                        set_from_outside(client, id, texts);
                                      });
    }
  }
  PeerMessage message;
  auto& answer = *message.mutable_parameter_answer();
  answer.set_id(request.id());
  if (!texts.empty()) {
    answer.set_error(fmt::format("{} settings of parameters wait already", kMostSettingsWaiting));
    link->send_to_client(client, message);
    return;
  }
  try {
    if (!request.name().empty()) {
      *answer.add_parameters() = to_record(parameters.get(request.name()));
    } else {
      for (const auto& parameter : parameters.all()) {
        *answer.add_parameters() = to_record(parameter);
      }
    }
  } catch (const std::invalid_argument& error) {
    answer.set_error(error.what());
  }
  link->send_to_client(client, message);
}

void Node::Impl::set_from_outside(const std::string& client, std::uint64_t id,
                                  const std::map<std::string, std::string>& texts) {
  PeerMessage message;
  auto& answer = *message.mutable_parameter_answer();
  answer.set_id(id);
  try {
    const auto changed = parameters.set(texts);
    for (const ParameterInfo& parameter : changed) *answer.add_parameters() = to_record(parameter);
    parameters_were_set(changed);
  } catch (const std::invalid_argument& error) {
    answer.set_error(error.what());
  }
  link->send_to_client(client, message);
}

}  // namespace prehend::graph
