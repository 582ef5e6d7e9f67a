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

// Waiting messages that are tried together: all that is prepared for a reader that is still full is
// prepared in vain.
constexpr std::size_t kTriedAtOnce = 256;

// Answers, feedback and the like that wait for one client. A client that reads takes a hundred
// thousand in a second, so who lets so many wait does not read.
constexpr std::size_t kMostOthersWaiting = 10'000;
constexpr std::size_t kMostOtherBytes = std::size_t{128} << 20;  // and one more message

std::size_t bytes_of(const Frames& frames) {
  std::size_t bytes = 0;
  for (const zmq::message_t& frame : frames) bytes += frame.size();
  return bytes;
}

// How long a closed socket tries to send what is left [ms].
constexpr int kLinger = 1000;

void set_up(zmq::socket_t& socket, int send_high_water_mark) {
  socket.set(zmq::sockopt::sndhwm, send_high_water_mark);
  socket.set(zmq::sockopt::rcvhwm, kHighWaterMark);
  socket.set(zmq::sockopt::maxmsgsize, kMaxFrameBytes);
  socket.set(zmq::sockopt::linger, kLinger);
}

}  // namespace

PeerChannels::PeerChannels(IoLoop& loop, CurveGate& gate, std::string instance, Events events,
                           std::shared_ptr<const SlabPool> slabs)
    : loop_(loop),
      gate_(gate),
      instance_(std::move(instance)),
      events_(std::move(events)),
      slabs_(std::move(slabs)),
      router_(loop.context(), zmq::socket_type::router) {
  set_up(router_, kHighWaterMark);
  router_.set(zmq::sockopt::router_mandatory, true);
  router_.set(zmq::sockopt::router_handover, true);
}

PeerChannels::~PeerChannels() {
  loop_.unwatch(router_);
  gate_.release(router_);
  for (auto& [name, server] : servers_) close(server);
}

void PeerChannels::close(Server& server) {
  loop_.unwatch(server.socket);
  loop_.unwatch(server.monitor);
  // First of all: ZeroMQ's thread would wait for ever to tell a monitor that nobody reads.
  zmq_socket_monitor(server.socket.handle(), nullptr, 0);
}

std::string PeerChannels::bind(const std::string& endpoint) {
  gate_.secure_server(router_, endpoint);
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
    gate_.secure_client(server.socket, endpoint);
    server.socket.connect(endpoint);
  } catch (const std::exception& error) {
    close(server);
    events_.malformed("endpoint '" + endpoint + "' of " + name + ": " + error.what());
    return;
  }
  loop_.watch(server.socket, [this, name] { read_server(name); });
  loop_.watch(server.monitor, [this, name] { read_monitor(name); });
  servers_.emplace(name, std::move(server));
}

bool PeerChannels::is_connected(const std::string& server) const {
  const auto found = servers_.find(server);
  return found != servers_.end() && found->second.is_connected;
}

bool PeerChannels::is_lost(const std::string& server) const {
  const auto found = servers_.find(server);
  return found != servers_.end() && found->second.was_lost;
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
  const SendResult result = send(found->second.socket, "", frames);
  loop_.touch(found->second.socket);
  return result == SendResult::kSent;
}

bool PeerChannels::send_to_client(const std::string& client,
                                  const msgs::graph::PeerMessage& message) {
  Waiting item;
  item.frames = to_wire(message);
  if (!backlogs_.count(client)) {
    const SendResult result = send_by_router(client, item.frames);
    if (result == SendResult::kNoRoute) lose_client(client);
    if (result != SendResult::kFull) return result == SendResult::kSent;
  }
  Backlog& backlog = backlogs_[client];
  const std::size_t bytes = bytes_of(item.frames);
  const bool is_full = backlog.others.count >= kMostOthersWaiting ||
                       (backlog.others.count > 0 && backlog.others.bytes + bytes > kMostOtherBytes);
  if (is_full) drop_client(client, backlog);
  if (backlog.is_dropped) {
    ++backlog.lost;
    ++dropped_;
    return false;
  }
  ++backlog.others.count;
  backlog.others.bytes += bytes;
  wait(client, std::move(item));
  return true;
}

// Without its state it would hold its tongue for ever, so one word waits in the place of all.
void PeerChannels::drop_client(const std::string& client, Backlog& backlog) {
  for (const Waiting& item : backlog.items) {
    if (item.head) item.drops->count_dropped(1);
  }
  const std::uint64_t lost = backlog.others.count;
  dropped_ += lost;
  backlog = {};
  backlog.is_dropped = true;
  backlog.lost = lost;
  wait(client, {});
  loop_.post([this, client, lost] {  // later, as in lose_client
    events_.client_dropped(client, lost);
    events_.client_lost(client);
  });
}

bool PeerChannels::publish_to_client(const std::string& client, std::uint32_t slab_reader,
                                     const Publication& publication,
                                     std::span<const OutgoingMessage> messages) {
  if (!backlogs_.count(client) &&
      send_messages(client, slab_reader, publication.head, messages) == SendResult::kNoRoute) {
    lose_client(client);
    return false;
  }
  for (const OutgoingMessage& message : messages) {
    Backlog& backlog = backlogs_[client];
    make_room(backlog, publication.head.topic, message.content->bytes(), publication.qos);
    auto& share = backlog.topics[publication.head.topic];
    ++share.count;
    share.bytes += message.content->bytes();
    publication.drops->count_waiting(share.count, share.bytes);
    wait(client, {{}, &publication.head, publication.drops, message, slab_reader});
  }
  return true;
}

SendResult PeerChannels::send_by_router(const std::string& client, Frames& frames) {
  loop_.touch(router_);
  return send(router_, client, frames);
}

SendResult PeerChannels::send_messages(const std::string& client, std::uint32_t slab_reader,
                                       const TopicHead& head,
                                       std::span<const OutgoingMessage>& messages) {
  while (!messages.empty()) {
    std::size_t count = 0;
    for (std::size_t bytes = 0; count < messages.size() && fits_in_batch(messages[count]);
         ++count) {
      bytes += messages[count].content->bytes();
      if (bytes > kMaxBatchBytes) break;
    }
    SendResult result = SendResult::kSent;
    if (count > 1) {
      Frames frames = to_wire(head, messages.first(count));
      result = send_by_router(client, frames);
    } else {
      count = 1;
      result = send_message(client, head, messages.front(), slab_reader);
    }
    if (result != SendResult::kSent) return result;
    messages = messages.subspan(count);
  }
  return SendResult::kSent;
}

SendResult PeerChannels::send_message(const std::string& client, const TopicHead& head,
                                      const OutgoingMessage& message, std::uint32_t slab_reader) {
  const auto& slab = message.content->encoded().slab;
  const bool by_slab = slab && slab_reader != 0;
  // The frames of a message in shared memory are so small that a socket would take hundreds for a
  // reader that has stopped.
  if (by_slab && slabs_ && slabs_->granted(slab_reader) >= kHighWaterMark) {
    return SendResult::kFull;
  }
  Frames frames = to_wire(head, message, slab_reader);
  if (by_slab) slab->grant(slab_reader);
  const SendResult result = send_by_router(client, frames);
  if (by_slab && result != SendResult::kSent) slab->revoke(slab_reader);
  return result;
}

void PeerChannels::make_room(Backlog& backlog, const std::string& topic, std::size_t bytes,
                             const QoS& qos) {
  auto& share = backlog.topics[topic];
  for (auto item = backlog.items.begin();
       share.count > 0 && (share.count >= qos.depth || share.bytes + bytes > qos.max_bytes);) {
    if (!item->head || item->head->topic != topic) {
      ++item;
      continue;
    }
    item->drops->count_dropped(1);
    share.bytes -= item->message.content->bytes();
    --share.count;
    item = backlog.items.erase(item);
  }
}

void PeerChannels::wait(const std::string& client, Waiting item) {
  backlogs_[client].items.push_back(std::move(item));
  if (retry_planned_) return;
  retry_planned_ = true;
  loop_.soon([this] { retry_backlogs(); });
}

// The first item, and with it the published messages behind it that may travel together.
SendResult PeerChannels::send_front(const std::string& client, Backlog& backlog) {
  const Waiting& front = backlog.items.front();
  if (!front.head && front.frames.empty()) {
    msgs::graph::PeerMessage word;
    word.mutable_dropped()->set_messages(backlog.lost);
    Frames frames = to_wire(word);
    const SendResult result = send_by_router(client, frames);
    if (result != SendResult::kSent) return result;
    drop_front(backlog);
    backlog.is_dropped = false;
    return result;
  }
  if (!front.head) {
    const std::size_t size = bytes_of(front.frames);
    const SendResult result = send_by_router(client, backlog.items.front().frames);
    if (result != SendResult::kSent) return result;
    drop_front(backlog);
    --backlog.others.count;
    backlog.others.bytes -= size;
    return result;
  }
  const TopicHead& head = *front.head;
  const std::shared_ptr<DropCounter> keeps_head = front.drops;
  std::vector<OutgoingMessage> run;
  std::size_t bytes = 0;
  for (const Waiting& item : backlog.items) {
    bytes += item.head ? item.message.content->bytes() : 0;
    if (run.size() == kTriedAtOnce) break;
    if (!run.empty() && (item.head != &head || bytes > kMaxBatchBytes)) break;
    run.push_back(item.message);
  }
  std::span<const OutgoingMessage> left = run;
  const SendResult result = send_messages(client, front.slab_reader, head, left);
  for (std::size_t sent = run.size() - left.size(); sent > 0; --sent) drop_front(backlog);
  return result;
}

void PeerChannels::drop_front(Backlog& backlog) {
  const Waiting& item = backlog.items.front();
  if (item.head) {
    auto& share = backlog.topics[item.head->topic];
    --share.count;
    share.bytes -= item.message.content->bytes();
  }
  backlog.items.pop_front();
}

void PeerChannels::retry_backlogs() {
  retry_planned_ = false;
  std::vector<std::string> lost;
  for (auto client = backlogs_.begin(); client != backlogs_.end();) {
    Backlog& backlog = client->second;
    SendResult result = SendResult::kSent;
    while (!backlog.items.empty() && result == SendResult::kSent) {
      result = send_front(client->first, backlog);
    }
    if (result == SendResult::kNoRoute) lost.push_back(client->first);
    client = backlog.items.empty() ? backlogs_.erase(client) : std::next(client);
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
    if (frames.size() == 5 || frames.size() == 3) {
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
  server->second.is_connected = event != ZMQ_EVENT_DISCONNECTED;
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
