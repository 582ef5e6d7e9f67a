#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

#include <zmq.hpp>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/curve.h"
#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/qos.h"

namespace prehend::graph {

/// Who counts messages that a slow reader never gets.
class DropCounter {
 public:
  virtual ~DropCounter() = default;
  virtual void count_dropped(std::uint64_t messages) = 0;
  /// So many messages wait for one reader now.
  virtual void count_waiting(std::uint64_t messages, std::uint64_t bytes) = 0;
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
    /// A message of a topic of `server`, or a batch of them: 5 or 3 frames, see frames.h.
    std::function<void(const std::string& server, Frames&)> topic_message;
    std::function<void(const std::string& client)> client_lost;
    /// So many messages (answers, feedback, ...) waited for a client that did not take them: they
    /// were thrown away, and client_lost comes, too. When it reads on, it is told.
    std::function<void(const std::string& client, std::uint64_t messages)> client_dropped;
    /// The connection broke; it comes back as server_back if the peer lives.
    std::function<void(const std::string& server)> server_lost;
    std::function<void(const std::string& server)> server_back;
    /// Damaged or foreign frames came; for counting.
    std::function<void(const std::string& what)> malformed;
  };

  /// `slabs`: where published messages may lie; null: nowhere.
  PeerChannels(IoLoop& loop, CurveGate& gate, std::string instance, Events events,
               std::shared_ptr<const SlabPool> slabs = nullptr);
  ~PeerChannels();

  /// Binds the ROUTER. Returns the endpoint with the real port.
  std::string bind(const std::string& endpoint);
  /// Connects to a peer; nothing if connected already.
  void connect(const std::string& server, const std::string& endpoint);
  /// True while the connection to a peer stands.
  bool is_connected(const std::string& server) const;
  /// True while the connection to a peer is broken that once stood.
  bool is_lost(const std::string& server) const;
  /// Forgets a peer that is gone, both ways.
  void forget(const std::string& peer);

  /// False when not connected or the connection's queue is full.
  bool send_to_server(const std::string& server, const msgs::graph::PeerMessage& message);
  /// Waits in a queue when the client is slow; false when it is not there, or was dropped because
  /// too much waited for it and has not read on since.
  bool send_to_client(const std::string& client, const msgs::graph::PeerMessage& message);
  /// As above for published messages, in order; small ones may travel together. While they wait
  /// they may be dropped, oldest of their topic first, when more wait than `qos` allows.
  /// `slab_reader`: the client's place among the leases, 0: it takes inline frames only.
  struct Publication {
    const TopicHead& head;  ///< lives as long as `drops`
    const QoS& qos;
    const std::shared_ptr<DropCounter>& drops;  ///< is told
  };
  bool publish_to_client(const std::string& client, std::uint32_t slab_reader,
                         const Publication& publication, std::span<const OutgoingMessage> messages);

  /// Messages other than published ones that were thrown away, as their clients did not take them.
  std::uint64_t dropped() const { return dropped_; }

  /// True when nothing waits for a slow client.
  bool is_idle() const { return backlogs_.empty(); }

 private:
  // A published message, or another one, which is dropped with its client only.
  struct Waiting {
    Frames frames;                    // of another one; none: the word that the client was dropped
    const TopicHead* head = nullptr;  // of a published one, in `drops`
    std::shared_ptr<DropCounter> drops;
    OutgoingMessage message;
    std::uint32_t slab_reader = 0;
  };
  struct Backlog {
    struct Share {
      std::size_t count = 0, bytes = 0;
    };
    std::deque<Waiting> items;
    std::map<std::string, Share> topics;
    Share others;             // what is not published
    bool is_dropped = false;  // the client, until it is told
    std::uint64_t lost = 0;   // messages it is told of
  };
  struct Server {
    zmq::socket_t socket;
    zmq::socket_t monitor;
    bool is_connected = false;
    bool was_lost = false;
  };

  void close(Server& server);
  void read_router();
  /// True when more may have come.
  bool read_server(const std::string& server);
  void read_monitor(const std::string& server);
  SendResult send_by_router(const std::string& client, Frames& frames);
  SendResult send_front(const std::string& client, Backlog& backlog);
  SendResult send_message(const std::string& client, const TopicHead& head,
                          const OutgoingMessage& message, std::uint32_t slab_reader);
  /// Sends as many as go without waiting; `messages` keeps the rest.
  SendResult send_messages(const std::string& client, std::uint32_t slab_reader,
                           const TopicHead& head, std::span<const OutgoingMessage>& messages);
  void wait(const std::string& client, Waiting item);
  void drop_client(const std::string& client, Backlog& backlog);
  void make_room(Backlog& backlog, const std::string& topic, std::size_t bytes, const QoS& qos);
  void drop_front(Backlog& backlog);
  void retry_backlogs();
  void lose_client(const std::string& client);

  IoLoop& loop_;
  CurveGate& gate_;
  const std::string instance_;
  Events events_;
  const std::shared_ptr<const SlabPool> slabs_;
  zmq::socket_t router_;
  std::map<std::string, Server> servers_;
  std::map<std::string, Backlog> backlogs_;  // of slow clients, never empty ones
  bool retry_planned_ = false;
  std::uint64_t dropped_ = 0;
  std::uint64_t monitor_count_ = 0;
};

}  // namespace prehend::graph
