#include "prehend/graph/link/peer_channels.h"

#include <cstring>
#include <vector>

namespace prehend::graph {
namespace {

// Messages that ZeroMQ itself holds for one slow reader, in each process. More wait in the backlog,
// where QoS rules.
constexpr int kHighWaterMark = 32;

// Messages received in one turn of the loop from one socket, so that no peer starves the others.
constexpr int kReceiveAtOnce = 64;

// How long a closed socket tries to send what is left [ms].
constexpr int kLinger = 1000;

void set_up(zmq::socket_t& socket, int send_high_water_mark) {
  socket.set(zmq::sockopt::sndhwm, send_high_water_mark);
  socket.set(zmq::sockopt::rcvhwm, kHighWaterMark);
  socket.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  socket.set(zmq::sockopt::linger, kLinger);
}

}  // namespace

PeerChannels::PeerChannels(IoLoop& loop, std::string instance, Events events)
    : loop_(loop),
      instance_(std::move(instance)),
      events_(std::move(events)),
      router_(loop.context(), zmq::socket_type::router) {
  set_up(router_, kHighWaterMark);
  router_.set(zmq::sockopt::router_mandatory, true);
  router_.set(zmq::sockopt::router_handover, true);
}

PeerChannels::~PeerChannels() {
  loop_.unwatch(router_);
  for (auto& [name, server] : servers_) close(server);
}

void PeerChannels::close(Server& server) {
  loop_.unwatch(server.socket);
  loop_.unwatch(server.monitor);
  // First of all: ZeroMQ's thread would wait for ever to tell a monitor that nobody reads.
  zmq_socket_monitor(server.socket.handle(), nullptr, 0);
}

std::string PeerChannels::bind(const std::string& endpoint) {
  router_.bind(endpoint);
  loop_.watch(router_, [this] { read_router(); });
  return router_.get(zmq::sockopt::last_endpoint);
}

void PeerChannels::connect(const std::string& name, const std::string& endpoint) {
  if (servers_.count(name)) return;
  Server server{zmq::socket_t(loop_.context(), zmq::socket_type::dealer),
                zmq::socket_t(loop_.context(), zmq::socket_type::pair)};
  set_up(server.socket, 1000);
  server.socket.set(zmq::sockopt::routing_id, instance_);
  server.socket.set(zmq::sockopt::reconnect_ivl, 100);
  const std::string monitor = "inproc://monitor-" + std::to_string(++monitor_count_);
  if (zmq_socket_monitor(server.socket.handle(), monitor.c_str(),
                         ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED) != 0) {
    throw zmq::error_t();
  }
  server.monitor.set(zmq::sockopt::linger, 0);
  server.monitor.connect(monitor);
  try {
    server.socket.connect(endpoint);
  } catch (const zmq::error_t& error) {
    close(server);
    events_.malformed("endpoint '" + endpoint + "' of " + name + ": " + error.what());
    return;
  }
  loop_.watch(server.socket, [this, name] { read_server(name); });
  loop_.watch(server.monitor, [this, name] { read_monitor(name); });
  servers_.emplace(name, std::move(server));
}

void PeerChannels::forget(const std::string& peer) {
  if (const auto found = servers_.find(peer); found != servers_.end()) {
    close(found->second);
    found->second.socket.set(zmq::sockopt::linger, 0);
    servers_.erase(found);
  }
  backlogs_.erase(peer);
}

bool PeerChannels::send_to_server(const std::string& server,
                                  const msgs::graph::PeerMessage& message) {
  const auto found = servers_.find(server);
  if (found == servers_.end()) return false;
  Frames frames = to_wire(message);
  return send(found->second.socket, "", frames) == SendResult::kSent;
}

bool PeerChannels::send_to_client(const std::string& client,
                                  const msgs::graph::PeerMessage& message) {
  Waiting item;
  item.frames = to_wire(message);
  return send_or_wait(client, std::move(item));
}

bool PeerChannels::publish_to_client(const std::string& client, const std::string& topic,
                                     TopicFrames& frames, const QoS& qos,
                                     const std::shared_ptr<DropCounter>& drops) {
  Waiting item;
  item.frames = to_wire(topic, frames);
  item.topic = topic;
  item.bytes = frames.message.bytes();
  item.drops = drops;
  if (const auto backlog = backlogs_.find(client); backlog != backlogs_.end()) {
    make_room(backlog->second, topic, item.bytes, qos);
  }
  return send_or_wait(client, std::move(item));
}

void PeerChannels::make_room(std::deque<Waiting>& backlog, const std::string& topic,
                             std::size_t bytes, const QoS& qos) {
  std::size_t count = 0;
  for (const Waiting& item : backlog) {
    if (item.topic != topic) continue;
    ++count;
    bytes += item.bytes;
  }
  for (auto item = backlog.begin();
       item != backlog.end() && count > 0 && (count >= qos.depth || bytes > qos.max_bytes);) {
    if (item->topic != topic) {
      ++item;
      continue;
    }
    item->drops->count_dropped(1);
    bytes -= item->bytes;
    --count;
    item = backlog.erase(item);
  }
}

bool PeerChannels::send_or_wait(const std::string& client, Waiting item) {
  auto backlog = backlogs_.find(client);
  if (backlog == backlogs_.end()) {
    const SendResult result = send(router_, client, item.frames);
    if (result == SendResult::kSent) return true;
    if (result == SendResult::kNoRoute) {
      lose_client(client);
      return false;
    }
    backlog = backlogs_.emplace(client, std::deque<Waiting>()).first;
  }
  backlog->second.push_back(std::move(item));
  if (!retry_planned_) {
    retry_planned_ = true;
    loop_.soon([this] { retry_backlogs(); });
  }
  return true;
}

void PeerChannels::retry_backlogs() {
  retry_planned_ = false;
  std::vector<std::string> lost;
  for (auto client = backlogs_.begin(); client != backlogs_.end();) {
    auto& backlog = client->second;
    SendResult result = SendResult::kSent;
    while (!backlog.empty()) {
      result = send(router_, client->first, backlog.front().frames);
      if (result != SendResult::kSent) break;
      backlog.pop_front();
    }
    if (result == SendResult::kNoRoute) lost.push_back(client->first);
    client = backlog.empty() || result == SendResult::kNoRoute ? backlogs_.erase(client)
                                                               : std::next(client);
  }
  for (const std::string& client : lost) lose_client(client);
  if (backlogs_.empty() || retry_planned_) return;
  retry_planned_ = true;
  loop_.soon([this] { retry_backlogs(); });
}

void PeerChannels::lose_client(const std::string& client) {
  backlogs_.erase(client);
  // Later: whoever sends now may be going through its list of clients.
  loop_.post([this, client] { events_.client_lost(client); });
}

void PeerChannels::read_router() {
  for (int i = 0; i < kReceiveAtOnce; ++i) {
    Frames frames = receive(router_);
    if (frames.empty()) return;
    msgs::graph::PeerMessage message;
    const bool good = frames.size() == 3 && frames[1].size() == 0 &&
                      message.ParseFromArray(frames[2].data(), static_cast<int>(frames[2].size()));
    if (good && message.content_case() != msgs::graph::PeerMessage::CONTENT_NOT_SET) {
      events_.client_message(frames[0].to_string(), message);
    } else {
      events_.malformed("a request of " + std::to_string(frames.size()) + " frames");
    }
  }
}

bool PeerChannels::read_server(const std::string& name) {
  for (int i = 0; i < kReceiveAtOnce; ++i) {
    const auto server = servers_.find(name);
    if (server == servers_.end()) return false;
    Frames frames = receive(server->second.socket);
    if (frames.empty()) return false;
    if (frames.size() == 5) {
      events_.topic_message(name, frames);
      continue;
    }
    msgs::graph::PeerMessage message;
    const bool good = frames.size() == 2 && frames[0].size() == 0 &&
                      message.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size()));
    if (good && message.content_case() != msgs::graph::PeerMessage::CONTENT_NOT_SET) {
      events_.server_message(name, message);
    } else {
      events_.malformed("an answer of " + std::to_string(frames.size()) + " frames from " + name);
    }
  }
  return true;
}

void PeerChannels::read_monitor(const std::string& name) {
  const auto server = servers_.find(name);
  if (server == servers_.end()) return;
  const Frames frames = receive(server->second.monitor);
  if (frames.empty() || frames[0].size() < 2) return;
  std::uint16_t event = 0;
  std::memcpy(&event, frames[0].data(), sizeof event);
  if (event == ZMQ_EVENT_DISCONNECTED) {
    server->second.was_lost = true;
    while (read_server(name)) {
    }  // what came before the end counts
    events_.server_lost(name);
  } else if (server->second.was_lost) {
    server->second.was_lost = false;
    events_.server_back(name);
  }
}

}  // namespace prehend::graph
