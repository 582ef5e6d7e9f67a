// The part of a node that runs in its loop's thread: what the registry and the peers say.

#include <fmt/format.h>

#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/node_impl.h"

namespace prehend::graph {

using msgs::graph::PeerMessage;

void Node::Impl::welcome(const std::string& folder) {
  try {
    if (const std::string endpoint = tcp_endpoint(); !endpoint.empty()) {
      record.set_endpoint(channels->bind(endpoint));
    } else {
      runtime_folder = folder;
      socket_file = socket_path(folder, record.instance());
      record.set_endpoint(channels->bind("ipc://" + socket_file));
    }
  } catch (const std::exception& error) {
    socket_file.clear();
    if (join_ended) join_ended(bind_failure(folder, error.what()));
    return;
  }
  send_record();
}

void Node::Impl::record_changed() {
  if (record.endpoint().empty() || std::exchange(record_change_pending, true)) return;
  link->loop->soon([this] {
    record_change_pending = false;
    send_record();
  });
}

void Node::Impl::send_record() {
  msgs::graph::NodeRecord full = record;
  publishers->fill(full);
  subscribers->fill(full);
  for (const auto& [name, service] : services) *full.add_services() = to_record(service->offer());
  for (const auto& [name, action] : action_servers)
    *full.add_actions() = to_record(action->offer());
  {
    const std::lock_guard lock(mutex);
    full.set_health(static_cast<msgs::graph::HealthLevel>(health.told().level));
    full.set_health_text(health.told().text);
  }
  full.clear_version();
  const std::uint64_t version = registry->update(full);
  publishers->record_sent(version);
  for (KnownWaiter& waiter : known_waiters) {
    if (waiter.version == 0) waiter.version = version;
  }
}

void Node::Impl::meet(const msgs::graph::NodeRecord& node) {
  subscribers->meet(node);
  calls->look_again();
  goals->look_again();
  publishers->check_opening();
  watch_new_topics(node);
  if (node.instance() == record.instance()) return;
  warn_if_out_of_reach(node);
  const auto check = [&](const auto& offers, const auto& own, const std::string& kind) {
    for (const auto& offer : offers) {
      if (!own.count(offer.name()) ||
          !conflicts_told.insert(node.instance() + kind + offer.name()).second) {
        continue;
      }
      hold_against(node.instance(), fmt::format("{}{} is served by this node and by node '{}'; "
                                                "clients take either",
                                                kind, offer.name(), node.name()));
    }
  };
  check(node.services(), services, "service ");
  check(node.actions(), action_servers, "action ");
}

void Node::Impl::lose_node(const std::string& instance) {
  publishers->lose_client(instance);
  deliveries->lose_client(instance);
  for (auto& [name, server] : action_servers) server->lose_client(instance);
  std::erase_if(conflicts_told,
                [&](const std::string& conflict) { return conflict.starts_with(instance); });
  {
    const std::lock_guard lock(mutex);
    health.release(instance);
  }
  tell_health();
  // Its last messages may be on their way still.
  departed[instance] = std::chrono::steady_clock::now();
}

void Node::Impl::forget_departed() {
  const auto before = std::chrono::steady_clock::now() - kLastMessages;
  for (auto node = departed.begin(); node != departed.end();) {
    if (node->second > before) {
      ++node;
      continue;
    }
    if (!registry->nodes().count(node->first)) {  // else it was not dead
      subscribers->lose_server(node->first);
      calls->lose_server(node->first);
      goals->lose_server(node->first);
      channels->forget(node->first);
    }
    node = departed.erase(node);
  }
}

void Node::Impl::take_client_message(const std::string& client, PeerMessage& message) {
  switch (message.content_case()) {
    case PeerMessage::kSubscribe:
      return publishers->join(client, message.subscribe());
    case PeerMessage::kUnsubscribe:
      return publishers->leave(client, message.unsubscribe());
    case PeerMessage::kCall:
      return take_call(client, *message.mutable_call());
    case PeerMessage::kGoal:
      return take_goal(client, *message.mutable_goal());
    case PeerMessage::kCancel:
      return take_cancel(client, message.cancel());
    case PeerMessage::kParameterRequest:
      return answer_parameters(client, message.parameter_request());
    case PeerMessage::kDeliveryAnswer:
      return deliveries->take_answer(client, message.delivery_answer());
    default:
      return count_malformed("an answer where a request belongs");
  }
}

void Node::Impl::take_server_message(const std::string& server, PeerMessage& message) {
  switch (message.content_case()) {
    case PeerMessage::kSubscribed:
      return subscribers->take_subscribed(server, message.subscribed());
    case PeerMessage::kHistoryEnd:
      return subscribers->take_history_end(server, message.history_end());
    case PeerMessage::kAnswer:
      return calls->take_answer(server, *message.mutable_answer());
    case PeerMessage::kFeedback:
      return goals->take_feedback(server, *message.mutable_feedback());
    case PeerMessage::kGoalResult:
      return goals->take_result(server, *message.mutable_goal_result());
    case PeerMessage::kDropped:
      return come_back(server, message.dropped().messages());
    case PeerMessage::kDeliveryQuestion:
      return answer_delivery(server,
                             [this, server, id = message.delivery_question().id()](auto answer) {
                               PeerMessage told;
                               *told.mutable_delivery_answer() = std::move(answer);
                               told.mutable_delivery_answer()->set_id(id);
                               channels->send_to_server(server, told);
                             });
    default:
      return count_malformed("a request where an answer belongs");
  }
}

// This node did not read for so long that the server has given it up.
void Node::Impl::come_back(const std::string& server, std::uint64_t messages) {
  log(LogLevel::kWarning,
      fmt::format(
          "{} has thrown away {} messages for this node, which did not take them; calls and "
          "goals there have failed, subscriptions are made again",
          server, messages));
  calls->lose_server(server);
  goals->lose_server(server);
  subscribers->rejoin(server);
}

void Node::Impl::take_call(const std::string& client, PeerMessage::Call& call) {
  const auto service = services.find(call.service());
  if (service != services.end()) return service->second->push(client, std::move(call));
  PeerMessage message;
  message.mutable_answer()->set_id(call.id());
  message.mutable_answer()->set_error("node '" + options.name + "' does not serve " +
                                      call.service());
  channels->send_to_client(client, message);
}

void Node::Impl::take_goal(const std::string& client, PeerMessage::Goal& goal) {
  const auto server = action_servers.find(goal.action());
  if (server != action_servers.end()) return server->second->accept(client, std::move(goal));
  PeerMessage message;
  message.mutable_goal_result()->set_id(goal.id());
  message.mutable_goal_result()->set_status(PeerMessage::FAILED);
  message.mutable_goal_result()->set_error("node '" + options.name + "' does not serve " +
                                           goal.action());
  channels->send_to_client(client, message);
}

void Node::Impl::take_cancel(const std::string& client, const PeerMessage::Cancel& cancel) {
  const auto server = action_servers.find(cancel.action());
  const bool served = server != action_servers.end();
  if (cancel.id() != 0) {
    if (served) server->second->cancel(client, cancel.id());
    return;
  }
  PeerMessage message;
  auto& answer = *message.mutable_answer();
  if (!served) {
    answer.set_error("node '" + options.name + "' does not serve " + cancel.action());
  } else if (!server->second->cancel_all()) {
    answer.set_error("action " + cancel.action() + " has no goal now");
  }
  channels->send_to_client(client, message);
}

void Node::Impl::count_malformed(const std::string& what) {
  ++malformed;
  malformed_example = what;
}

void Node::Impl::watch_new_topics(const msgs::graph::NodeRecord& node) {
  for (const auto& end : node.publishers()) {
    if (!topics_told.insert(end.topic()).second) continue;
    for (const auto& watcher : topic_watchers) tell_topic(watcher, end.topic());
  }
}

void Node::Impl::tell_topic(const std::function<void(const TopicInfo&)>& watcher,
                            const std::string& topic) {
  TopicInfo info;
  info.topic = topic;
  for (const auto& [instance, node] : registry->nodes()) {
    for (const auto& end : node.publishers()) {
      if (end.topic() != topic) continue;
      if (info.publishers.empty()) {
        info.schema_name = end.schema_name();
        info.schema_hash = end.schema_hash();
        info.policy = static_cast<QoS::Policy>(end.policy());
        info.depth = end.depth();
      }
      info.publishers.push_back(node.name());
    }
  }
  link->executor->schedule("watch_topics", [watcher, info] { watcher(info); });
}

void Node::Impl::tick() {
  std::uint64_t failed_callbacks = 0;
  forget_departed();
  calls->check_connections();
  goals->check_connections();
  for (auto& [name, server] : action_servers) server->probe_client();
  subscribers->forget_withdrawn();
  publishers->check_opening();
  publishers->log_losses(false);
  subscribers->log_losses(false);
  tell_health();
  {
    const std::lock_guard lock(mutex);
    failed_callbacks = health.failures();
  }
  statistics->tick(malformed, channels->dropped(), failed_callbacks);
  if (malformed_line.is_due(malformed)) {
    log(LogLevel::kError, fmt::format("{} damaged or foreign messages thrown away in all, the last "
                                      "one: {}",
                                      malformed, malformed_example));
  }
}

void Node::Impl::flush_and_leave() {
  publishers->check_opening();
  const bool idle = !joined || (channels->is_idle() && publishers->is_idle() &&
                                !(link->slabs && link->slabs->has_grants()));
  if (!idle && std::chrono::steady_clock::now() < flush_deadline) {
    link->loop->soon([this] { link->loop->post([this] { flush_and_leave(); }); });
    return;
  }
  publishers->log_losses(true);
  subscribers->log_losses(true);
  publishers->stop();
  known_waiters.clear();
  registry->goodbye();
  link->loop->close();
}

}  // namespace prehend::graph
