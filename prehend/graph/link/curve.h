#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <zmq.hpp>

#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/socket_monitor.h"
#include "prehend/graph/security.h"

namespace prehend::graph {

/// Readies a socket for connecting to `endpoint`: CURVE on tcp if there are keys, and limits within
/// which a broken tcp connection is noticed. Throws std::runtime_error when the endpoint is beyond
/// loopback and there are no keys.
void secure_client(zmq::socket_ref socket, const std::string& endpoint,
                   const std::optional<GraphKeys>& keys);

/// Events of a client's socket (ZMQ_EVENT_...) that tell of its keys.
int key_events();

/// What such events say of the keys of who listens at the other end. Both ends find out that they
/// do not fit, and who is first hangs up: the same mistake shows as a refusal that says why, or as
/// a connection that is broken off, now so, now so.
class KeyTrouble {
 public:
  explicit KeyTrouble(bool has_keys) : has_keys_(has_keys) {}
  void take(std::uint16_t event);
  /// As the end of a sentence; "" when the connection stands, or nothing is known.
  std::string words() const;

 private:
  bool has_keys_;
  bool other_protocol_ = false, refused_ = false, broken_off_ = false;
};

/// Guards the sockets of one ZeroMQ context. Every member of a graph is CURVE server and client
/// with the same key pair. A peer proves as client that it has the secret key, as the gate answers
/// the context's ZAP requests (ZeroMQ RFC 27) and admits only the graph's public key. What is
/// refused is counted, and logged once a second. In the loop's thread only, or while it does not
/// run.
class CurveGate {
 public:
  using Log = std::function<void(const std::string&)>;

  CurveGate(IoLoop& loop, std::optional<GraphKeys> keys, Log log);
  ~CurveGate();
  CurveGate(const CurveGate&) = delete;
  CurveGate& operator=(const CurveGate&) = delete;

  /// Readies a socket for binding to `endpoint`; throws as secure_client. Before the socket is
  /// closed it has to be released.
  void secure_server(zmq::socket_ref socket, const std::string& endpoint);
  void release(zmq::socket_ref socket);
  void secure_client(zmq::socket_ref socket, const std::string& endpoint) const;

  bool has_keys() const { return keys_.has_value(); }
  /// Connections that were turned away.
  std::uint64_t refused() const { return refused_; }

 private:
  void answer_requests();

  IoLoop& loop_;
  const std::optional<GraphKeys> keys_;
  const Log log_;
  std::string admitted_key_;  // binary
  zmq::socket_t requests_;
  std::map<void*, std::unique_ptr<SocketMonitor>> monitors_;
  std::uint64_t refused_ = 0;
  LossLine refused_line_;
};

}  // namespace prehend::graph
