#include "prehend/graph/link/curve.h"

#include <fmt/format.h>

#include <chrono>

#include "prehend/graph/link/frames.h"

namespace prehend::graph {
namespace {

constexpr int kConnectTimeout = 1000;  // ms; the kernel's own waits double up to a minute
constexpr int kDeadAfter = 3000;       // ms without any progress

constexpr int kRefusals = ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
// A peer that learns first that it does not fit hangs up.
constexpr int kBrokenOff = ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;

// The kernel watches the connection, not ZeroMQ's heartbeats: those stand in line behind a large
// message, and a link that takes longer than the limit for one would count as broken for ever.
void set_up_tcp(zmq::socket_ref socket, const std::string& endpoint) {
  socket.set(zmq::sockopt::ipv6, endpoint.find('[') != std::string::npos);
  socket.set(zmq::sockopt::connect_timeout, kConnectTimeout);
  socket.set(zmq::sockopt::tcp_keepalive, 1);
  socket.set(zmq::sockopt::tcp_keepalive_idle, 1);
  socket.set(zmq::sockopt::tcp_keepalive_intvl, 1);
  socket.set(zmq::sockopt::tcp_keepalive_cnt, kDeadAfter / 1000);
  socket.set(zmq::sockopt::tcp_maxrt, kDeadAfter);
}

bool is_tcp(const std::string& endpoint) { return endpoint.starts_with("tcp://"); }

}  // namespace

void secure_client(zmq::socket_ref socket, const std::string& endpoint,
                   const std::optional<GraphKeys>& keys) {
  check_endpoint_is_safe(endpoint, keys.has_value());
  if (!is_tcp(endpoint)) return;
  set_up_tcp(socket, endpoint);
  if (!keys) return;
  socket.set(zmq::sockopt::curve_serverkey, keys->public_key);
  socket.set(zmq::sockopt::curve_publickey, keys->public_key);
  socket.set(zmq::sockopt::curve_secretkey, keys->secret_key);
}

int key_events() { return ZMQ_EVENT_HANDSHAKE_SUCCEEDED | kRefusals | kBrokenOff; }

void KeyTrouble::take(std::uint16_t event) {
  if (event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
    other_protocol_ = refused_ = broken_off_ = false;
  } else if (event == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL) {
    other_protocol_ = true;
  } else if (event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
    refused_ = true;
  } else if ((event & key_events()) != 0) {
    broken_off_ = true;
  }
}

std::string KeyTrouble::words() const {
  if (has_keys_) {
    if (other_protocol_) return "what listens there uses no keys";
    if (refused_) return "the registry there has other keys";
    return broken_off_ ? "the registry there has other keys, or uses no keys" : "";
  }
  if (other_protocol_) {
    return "what listens there uses keys, give them with --keys FILE or PREHEND_KEYS";
  }
  if (!broken_off_ && !refused_) return "";
  return "what listens there breaks off: if it uses keys, give them with --keys FILE or "
         "PREHEND_KEYS";
}

CurveGate::CurveGate(IoLoop& loop, std::optional<GraphKeys> keys, Log log)
    : loop_(loop), keys_(std::move(keys)), log_(std::move(log)) {
  loop_.every(std::chrono::seconds(1), [this] {
    if (!refused_line_.is_due(refused_)) return;
    log_(fmt::format("{} connections refused in all: {}", refused_,
                     keys_ ? "the peers have no keys or other ones than this graph, or broke off"
                           : "the peers use keys, and this graph has none"));
  });
  if (!keys_) return;
  admitted_key_.resize(32);
  zmq_z85_decode(reinterpret_cast<std::uint8_t*>(admitted_key_.data()), keys_->public_key.c_str());
  requests_ = zmq::socket_t(loop_.context(), zmq::socket_type::rep);
  requests_.set(zmq::sockopt::linger, 0);
  requests_.bind("inproc://zeromq.zap.01");
  loop_.watch(requests_, [this] { answer_requests(); });
}

CurveGate::~CurveGate() {
  if (keys_) loop_.unwatch(requests_);
}

void CurveGate::secure_server(zmq::socket_ref socket, const std::string& endpoint) {
  check_endpoint_is_safe(endpoint, keys_.has_value());
  if (!is_tcp(endpoint)) return;
  set_up_tcp(socket, endpoint);
  if (keys_) {
    socket.set(zmq::sockopt::curve_server, true);
    socket.set(zmq::sockopt::curve_secretkey, keys_->secret_key);
  }
  monitors_[socket.handle()] =
      std::make_unique<SocketMonitor>(loop_, socket, keys_ ? kRefusals | kBrokenOff : kRefusals,
                                      [this](std::uint16_t, std::uint32_t) { ++refused_; });
}

void CurveGate::release(zmq::socket_ref socket) { monitors_.erase(socket.handle()); }

void CurveGate::secure_client(zmq::socket_ref socket, const std::string& endpoint) const {
  graph::secure_client(socket, endpoint, keys_);
}

// A request is version | id | domain | address | routing id | mechanism | credentials, the last for
// CURVE the client's public key.
void CurveGate::answer_requests() {
  while (true) {
    Frames request = receive(requests_);
    if (request.empty()) return;
    const bool admitted = request.size() == 7 && request[5].to_string_view() == "CURVE" &&
                          request[6].to_string_view() == admitted_key_;
    Frames reply(6);
    reply[0] = zmq::message_t(std::string("1.0"));
    if (request.size() > 1) reply[1] = std::move(request[1]);
    reply[2] = zmq::message_t(std::string(admitted ? "200" : "400"));
    reply[3] = zmq::message_t(std::string(admitted ? "OK" : "not this graph's key"));
    graph::send(requests_, "", reply);
  }
}

}  // namespace prehend::graph
