#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include <zmq.hpp>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/qos.h"

namespace prehend::graph {

/// Who counts messages that a slow reader never gets.
class DropCounter {
 public:
  virtual ~DropCounter() = default;
  virtual void count_dropped(std::uint64_t messages) = 0;
};

/// The connections between this node and its peers. Each node has one ROUTER socket, where peers'
/// DEALER sockets connect; a peer is known by its instance string, which is its routing id. What a
/// peer asks of this node (subscribe, call, goal) comes in by the ROUTER and is answered there;
/// what this node asks of a peer goes out by the DEALER to it. In the loop's thread only.
class PeerChannels {
 public:
  struct Events {
    /// A client asks for something.
    std::function<void(const std::string& client, msgs::graph::PeerMessage&)> client_message;
    /// A server answers.
    std::function<void(const std::string& server, msgs::graph::PeerMessage&)> server_message;
    /// A message of a topic of `server`: `topic | Envelope | body | prefix | payload`.
    std::function<void(const std::string& server, Frames&)> topic_message;
    std::function<void(const std::string& client)> client_lost;
    /// The connection broke; it comes back as server_back if the peer lives.
    std::function<void(const std::string& server)> server_lost;
    std::function<void(const std::string& server)> server_back;
    /// Damaged or foreign frames came; for counting.
    std::function<void(const std::string& what)> malformed;
  };

  PeerChannels(IoLoop& loop, std::string instance, Events events);
  ~PeerChannels();

  /// Binds the ROUTER. Returns the endpoint with the real port.
  std::string bind(const std::string& endpoint);
  /// Connects to a peer; nothing if connected already.
  void connect(const std::string& server, const std::string& endpoint);
  /// Forgets a peer that is gone, both ways.
  void forget(const std::string& peer);

  /// False when not connected or the connection's queue is full.
  bool send_to_server(const std::string& server, const msgs::graph::PeerMessage& message);
  /// Waits in a queue when the client is slow; false when it is not there.
  bool send_to_client(const std::string& client, const msgs::graph::PeerMessage& message);
  /// As above for a published message. While it waits it may be dropped, oldest of its topic first,
  /// when more wait than `qos` allows; `drops` is told.
  bool publish_to_client(const std::string& client, const std::string& topic, TopicFrames& frames,
                         const QoS& qos, const std::shared_ptr<DropCounter>& drops);

  /// True when nothing waits for a slow client.
  bool is_idle() const { return backlogs_.empty(); }

 private:
  struct Waiting {
    Frames frames;
    std::string topic;  // empty: not a published message, never dropped
    std::size_t bytes = 0;
    std::shared_ptr<DropCounter> drops;
  };
  struct Server {
    zmq::socket_t socket;
    zmq::socket_t monitor;
    bool was_lost = false;
  };

  void close(Server& server);
  void read_router();
  /// True when more may have come.
  bool read_server(const std::string& server);
  void read_monitor(const std::string& server);
  bool send_or_wait(const std::string& client, Waiting item);
  void make_room(std::deque<Waiting>& backlog, const std::string& topic, std::size_t bytes,
                 const QoS& qos);
  void retry_backlogs();
  void lose_client(const std::string& client);

  IoLoop& loop_;
  const std::string instance_;
  Events events_;
  zmq::socket_t router_;
  std::map<std::string, Server> servers_;
  std::map<std::string, std::deque<Waiting>> backlogs_;  // of slow clients, never empty ones
  bool retry_planned_ = false;
  std::uint64_t monitor_count_ = 0;
};

}  // namespace prehend::graph
