#include "prehend/viewing/hub.h"

#include <algorithm>

#include <fmt/format.h>

namespace prehend::viewing {

struct Hub::Viewer {
  Viewer(ViewerId its_id, std::string its_peer, Wire its_wire, std::size_t limit)
      : id(its_id), peer(std::move(its_peer)), wire(std::move(its_wire)), outbox(limit) {}

  const ViewerId id;
  const std::string peer;
  const Wire wire;
  Outbox outbox;
  std::map<std::uint32_t, ChannelId> subscriptions;  // by the viewer's id
  std::map<ChannelId, std::uint32_t> by_channel;
  std::set<std::uint32_t> client_channels;
  std::set<std::string> parameters;  // whose changes it wants to know
  bool all_parameters = false;
  bool wants_graph = false;
  bool given_up = false;
  std::uint64_t told_losses = 0;
};

Hub::Hub(std::string name, std::string session, Handlers handlers, ViewerLimits limits, Post post)
    : info_{std::move(name), {}, {"protobuf", "json"}, std::move(session)},
      handlers_(std::move(handlers)),
      limits_(limits),
      post_(std::move(post)) {}

Hub::~Hub() = default;

std::vector<std::string> Hub::capabilities() const {
  std::vector<std::string> offered{"time", "connectionGraph"};
  if (handlers_.on_client_message) offered.emplace_back("clientPublish");
  if (handlers_.on_get_parameters) {
    offered.insert(offered.end(), {"parameters", "parametersSubscribe"});
  }
  if (handlers_.on_service_call) offered.emplace_back("services");
  if (handlers_.on_fetch_asset) offered.emplace_back("assets");
  return offered;
}

bool Hub::is_offered(const Request& request) const {
  if (std::holds_alternative<AdvertiseClient>(request)) return bool(handlers_.on_client_message);
  if (std::holds_alternative<GetParameters>(request)) return bool(handlers_.on_get_parameters);
  if (std::holds_alternative<SetParameters>(request)) return bool(handlers_.on_set_parameters);
  if (std::holds_alternative<FetchAsset>(request)) return bool(handlers_.on_fetch_asset);
  return true;
}

// --- to viewers ---------------------------------------------------------------------------------

void Hub::push(Viewer& viewer, Outbox::Frame frame) {
  if (viewer.given_up) return;
  frame.since = std::chrono::steady_clock::now();
  viewer.outbox.push(std::move(frame));
  if (!viewer.outbox.overflowed()) return viewer.wire.wake();
  viewer.given_up = true;
  news(StatusLevel::kWarning,
       fmt::format("viewer {} does not read: it is given up with {} MB waiting for it", viewer.peer,
                   viewer.outbox.bytes() >> 20));
  viewer.wire.close("you do not read what you asked for");
}

void Hub::send(Viewer& viewer, std::string text) {
  Outbox::Frame frame;
  frame.payload = std::make_shared<const std::string>(std::move(text));
  push(viewer, std::move(frame));
}

void Hub::send_binary(Viewer& viewer, std::string bytes) {
  Outbox::Frame frame;
  frame.is_text = false;
  frame.payload = std::make_shared<const std::string>(std::move(bytes));
  push(viewer, std::move(frame));
}

void Hub::send_all(const std::string& text) {
  for (const auto& [id, viewer] : viewers_) send(*viewer, text);
}

void Hub::refuse(Viewer& viewer, const std::string& why) {
  send(viewer, status_text(StatusLevel::kError, why));
}

void Hub::news(StatusLevel level, const std::string& text) const {
  if (handlers_.on_news) handlers_.on_news(level, text);
}

void Hub::later(ViewerId id, Handled handled) {
  post_([this, id, handled = std::move(handled), alive = std::weak_ptr(alive_)] {
    if (alive.expired()) return;
    const auto viewer = viewers_.find(id);
    if (viewer != viewers_.end()) handled(*viewer->second);
  });
}

// --- channels and services ----------------------------------------------------------------------

void Hub::add_channel(ChannelId id, Channel channel) {
  if (!viewers_.empty()) send_all(advertise_text({{id, channel}}));
  channels_[id].channel = std::move(channel);
}

void Hub::remove_channel(ChannelId id) {
  const auto offered = channels_.find(id);
  if (offered == channels_.end()) return;
  send_all(unadvertise_text({id}));
  for (const ViewerId viewer : std::set<ViewerId>(offered->second.viewers)) {
    Viewer& its = *viewers_.at(viewer);
    leave_channel(its, its.by_channel.at(id));
  }
  channels_.erase(id);
}

void Hub::add_service(ServiceId id, ServiceType service) {
  if (!viewers_.empty()) send_all(advertise_services_text({{id, service}}));
  services_[id] = std::move(service);
}

void Hub::remove_service(ServiceId id) {
  if (services_.erase(id) > 0) send_all(unadvertise_services_text({id}));
}

void Hub::keep(Offered& offered, Kept message) {
  offered.kept_bytes += message.payload->size();
  offered.kept.push_back(std::move(message));
  const auto of_sender = [&](const Kept& one) { return one.sender == offered.kept.back().sender; };
  const auto forget = [&](std::deque<Kept>::iterator one) {
    offered.kept_bytes -= one->payload->size();
    offered.kept.erase(one);
  };
  const auto count = std::count_if(offered.kept.begin(), offered.kept.end(), of_sender);
  if (static_cast<std::size_t>(count) > offered.channel.latched) {
    forget(std::find_if(offered.kept.begin(), offered.kept.end(), of_sender));
  }
  while (offered.kept_bytes > limits_.latched_bytes && offered.kept.size() > 1) {
    forget(offered.kept.begin());
  }
}

void Hub::send_message(Viewer& viewer, const Offered& offered, std::uint32_t subscription,
                       const Kept& message) {
  Outbox::Frame frame;
  const bool is_latched = offered.channel.latched > 0 && !offered.channel.may_drop;
  frame.kind = is_latched ? Outbox::Kind::kLatched : Outbox::Kind::kStream;
  frame.is_text = false;
  frame.subscription = subscription;
  if (is_latched) {
    frame.sender = message.sender;
    frame.latched = offered.channel.latched;
  }
  frame.head = message_head(subscription, message.time);
  frame.head_size = frame.head.size();
  frame.payload = message.payload;
  push(viewer, std::move(frame));
}

void Hub::publish(ChannelId id, std::uint64_t time, const Payload& payload,
                  const std::string& sender) {
  const auto found = channels_.find(id);
  if (found == channels_.end() || found->second.viewers.empty()) return;
  Offered& offered = found->second;
  const Kept message{time, payload, sender};
  if (offered.channel.latched > 0) keep(offered, message);
  for (const ViewerId viewer : offered.viewers) {
    Viewer& its = *viewers_.at(viewer);
    send_message(its, offered, its.by_channel.at(id), message);
  }
}

void Hub::set_time(std::uint64_t time) {
  for (const auto& [id, viewer] : viewers_) {
    viewer->outbox.set_time(time);
    viewer->wire.wake();
  }
}

void Hub::set_graph(ConnectionGraph graph) {
  for (const auto& [id, viewer] : viewers_) {
    const bool same = graph.published == graph_.published &&
                      graph.subscribed == graph_.subscribed && graph.services == graph_.services;
    if (viewer->wants_graph && !same) send(*viewer, connection_graph_text(graph_, graph));
  }
  graph_ = std::move(graph);
}

void Hub::publish_parameters(const std::vector<Parameter>& parameters) {
  for (const auto& [id, viewer] : viewers_) {
    std::vector<Parameter> wanted;
    for (const Parameter& one : parameters) {
      if (viewer->all_parameters || viewer->parameters.count(one.name) > 0) wanted.push_back(one);
    }
    if (!wanted.empty()) send(*viewer, parameter_values_text(wanted, std::nullopt));
  }
}

void Hub::tell(StatusLevel level, const std::string& message, const std::string& id) {
  send_all(status_text(level, message, id));
}

// --- viewers ------------------------------------------------------------------------------------

ViewerId Hub::connect(const std::string& peer, Wire wire) {
  const ViewerId id = ++last_viewer_;
  auto& viewer =
      *viewers_
           .emplace(id, std::make_unique<Viewer>(id, peer, std::move(wire), limits_.outbox_bytes))
           .first->second;
  ServerInfo info = info_;
  info.capabilities = capabilities();
  send(viewer, server_info_text(info));
  std::vector<std::pair<ChannelId, Channel>> channels;
  for (const auto& [channel, offered] : channels_) channels.emplace_back(channel, offered.channel);
  send(viewer, advertise_text(channels));
  if (!services_.empty()) {
    send(viewer, advertise_services_text({services_.begin(), services_.end()}));
  }
  news(StatusLevel::kInfo, fmt::format("viewer {} came: {} now", peer, viewers_.size()));
  return id;
}

void Hub::disconnect(ViewerId id) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return;
  Viewer& viewer = *found->second;
  viewer.given_up = true;  // nothing is sent any more
  while (!viewer.subscriptions.empty()) leave_channel(viewer, viewer.subscriptions.begin()->first);
  if (handlers_.on_client_unadvertise) {
    for (const std::uint32_t channel : viewer.client_channels) {
      handlers_.on_client_unadvertise(id, channel);
    }
  }
  const std::string peer = viewer.peer;
  const std::uint64_t dropped = viewer.outbox.dropped();
  viewers_.erase(found);
  news(StatusLevel::kInfo,
       fmt::format("viewer {} left{}: {} now", peer,
                   dropped > 0 ? fmt::format(", {} messages were too many for it", dropped) : "",
                   viewers_.size()));
}

void Hub::leave_channel(Viewer& viewer, std::uint32_t subscription) {
  const auto found = viewer.subscriptions.find(subscription);
  if (found == viewer.subscriptions.end()) return;
  const ChannelId channel = found->second;
  viewer.subscriptions.erase(found);
  viewer.by_channel.erase(channel);
  viewer.outbox.forget(subscription);
  Offered& offered = channels_.at(channel);
  offered.viewers.erase(viewer.id);
  if (!offered.viewers.empty()) return;
  offered.kept.clear();  // who comes next gets them from where they came
  offered.kept_bytes = 0;
  if (handlers_.on_channel_wanted) handlers_.on_channel_wanted(channel, false);
}

std::optional<Outbox::Frame> Hub::next_frame(ViewerId id) {
  const auto viewer = viewers_.find(id);
  if (viewer == viewers_.end()) return std::nullopt;
  return viewer->second->outbox.pop(std::chrono::steady_clock::now());
}

void Hub::tell_losses() {
  for (const auto& [id, viewer] : viewers_) {
    const std::uint64_t dropped = viewer->outbox.dropped();
    if (dropped == viewer->told_losses) continue;
    if (viewer->told_losses == 0) {
      news(StatusLevel::kWarning,
           fmt::format("viewer {} is slow: it does not get all messages", viewer->peer));
    }
    viewer->told_losses = dropped;
    send(*viewer,
         status_text(StatusLevel::kWarning,
                     fmt::format("{} messages were too many for this connection and were left out",
                                 dropped),
                     "dropped"));
  }
}

// --- from viewers -------------------------------------------------------------------------------

void Hub::receive_text(ViewerId id, std::string_view text) {
  Viewer& viewer = *viewers_.at(id);
  try {
    const Request request = parse_request(text);
    if (!is_offered(request)) throw ProtocolError("this is not offered here");
    std::visit([&](const auto& one) { handle(viewer, one); }, request);
  } catch (const std::exception& error) {
    refuse(viewer, error.what());
  }
}

void Hub::receive_binary(ViewerId id, std::string_view bytes) {
  Viewer& viewer = *viewers_.at(id);
  try {
    std::visit([&](const auto& one) { handle(viewer, one); }, parse_binary(bytes));
  } catch (const std::exception& error) {
    refuse(viewer, error.what());
  }
}

void Hub::handle(Viewer& viewer, const Subscribe& request) {
  for (const Subscribe::One& one : request.subscriptions) {
    const auto channel = channels_.find(one.channel);
    if (channel == channels_.end()) {
      refuse(viewer, fmt::format("subscribe: there is no channel {}", one.channel));
      continue;
    }
    if (viewer.by_channel.count(one.channel) > 0 || viewer.subscriptions.count(one.id) > 0) {
      refuse(viewer, fmt::format("subscribe: channel {} ({}) has a subscription of this viewer, or "
                                 "its id {} is taken",
                                 one.channel, channel->second.channel.topic, one.id));
      continue;
    }
    Offered& offered = channel->second;
    viewer.by_channel[one.channel] = one.id;
    viewer.subscriptions[one.id] = one.channel;
    offered.viewers.insert(viewer.id);
    for (const Kept& message : offered.kept) send_message(viewer, offered, one.id, message);
    if (offered.viewers.size() == 1 && handlers_.on_channel_wanted) {
      handlers_.on_channel_wanted(one.channel, true);
    }
  }
}

void Hub::handle(Viewer& viewer, const Unsubscribe& request) {
  for (const std::uint32_t id : request.ids) {
    // A channel that went took its subscription with it, which the viewer may not know yet.
    leave_channel(viewer, id);
  }
}

void Hub::handle(Viewer& viewer, const AdvertiseClient& request) {
  for (const ClientChannel& channel : request.channels) {
    if (viewer.client_channels.size() >= limits_.client_channels) {
      throw ProtocolError(
          fmt::format("advertise: a viewer may have {} channels at most", limits_.client_channels));
    }
    if (viewer.client_channels.count(channel.id) > 0) {
      refuse(viewer, fmt::format("advertise: channel {} is there already", channel.id));
      continue;
    }
    try {
      handlers_.on_client_advertise(viewer.id, channel);
      viewer.client_channels.insert(channel.id);
    } catch (const std::exception& error) {
      refuse(viewer, "advertise: " + std::string(error.what()));
    }
  }
}

void Hub::handle(Viewer& viewer, const UnadvertiseClient& request) {
  for (const std::uint32_t id : request.ids) {
    if (viewer.client_channels.erase(id) == 0) {
      refuse(viewer, fmt::format("unadvertise: there is no channel {} of this viewer", id));
    } else {
      handlers_.on_client_unadvertise(viewer.id, id);
    }
  }
}

std::function<void(ParameterAnswer)> Hub::parameter_answer(ViewerId id,
                                                           std::optional<std::string> word) {
  return [this, id, word = std::move(word), alive = std::weak_ptr(alive_)](ParameterAnswer answer) {
    if (alive.expired()) return;
    later(id, [this, word, answer = std::move(answer)](Viewer& viewer) {
      if (!answer.error.empty()) refuse(viewer, answer.error);
      send(viewer, parameter_values_text(answer.parameters, word));
    });
  };
}

void Hub::handle(Viewer& viewer, const GetParameters& request) {
  handlers_.on_get_parameters(request.names, parameter_answer(viewer.id, request.id));
}

void Hub::handle(Viewer& viewer, const SetParameters& request) {
  handlers_.on_set_parameters(request.parameters, parameter_answer(viewer.id, request.id));
}

void Hub::handle(Viewer& viewer, const SubscribeParameters& request) {
  if (request.names.empty()) viewer.all_parameters = true;
  if (viewer.parameters.size() + request.names.size() > limits_.parameter_names) {
    throw ProtocolError(fmt::format("subscribeParameterUpdates: a viewer may name {} at most",
                                    limits_.parameter_names));
  }
  viewer.parameters.insert(request.names.begin(), request.names.end());
}

void Hub::handle(Viewer& viewer, const UnsubscribeParameters& request) {
  if (request.names.empty()) {
    viewer.all_parameters = false;
    viewer.parameters.clear();
  }
  for (const std::string& name : request.names) viewer.parameters.erase(name);
}

void Hub::handle(Viewer& viewer, const SubscribeGraph&) {
  viewer.wants_graph = true;
  send(viewer, connection_graph_text({}, graph_));
}

void Hub::handle(Viewer& viewer, const UnsubscribeGraph&) { viewer.wants_graph = false; }

void Hub::handle(Viewer& viewer, const FetchAsset& request) {
  handlers_.on_fetch_asset(request.uri, [this, id = viewer.id, number = request.request,
                                         alive = std::weak_ptr(alive_)](AssetAnswer answer) {
    if (alive.expired()) return;
    later(id, [this, number, answer = std::move(answer)](Viewer& asking) {
      send_binary(asking, asset_response(number, answer.error, answer.content));
    });
  });
}

void Hub::handle(Viewer& viewer, const ClientMessage& message) {
  if (viewer.client_channels.count(message.channel) == 0) {
    throw ProtocolError(
        fmt::format("there is no channel {} of this viewer: advertise it first", message.channel));
  }
  handlers_.on_client_message(viewer.id, message.channel, message.payload);
}

void Hub::handle(Viewer& viewer, const ServiceCall& call) {
  const auto answer = [this, id = viewer.id, service = call.service, number = call.call,
                       alive = std::weak_ptr(alive_)](ServiceAnswer said) {
    if (alive.expired()) return;
    later(id, [this, service, number, said = std::move(said)](Viewer& calling) {
      if (!said.error.empty()) {
        return send(calling, service_failure_text(service, number, said.error));
      }
      send_binary(calling, service_response(service, number, said.encoding, said.payload));
    });
  };
  if (services_.count(call.service) == 0 || !handlers_.on_service_call) {
    return answer({fmt::format("there is no service {}", call.service), "", ""});
  }
  try {
    handlers_.on_service_call(call.service, call, answer);
  } catch (const std::exception& error) {
    answer({error.what(), "", ""});
  }
}

}  // namespace prehend::viewing
