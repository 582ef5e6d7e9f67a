#include "prehend/graph/link/socket_monitor.h"

#include <atomic>
#include <cstring>
#include <string>

#include "prehend/graph/link/frames.h"

namespace prehend::graph {

SocketMonitor::SocketMonitor(IoLoop& loop, zmq::socket_ref socket, int events,
                             std::function<void(std::uint16_t, std::uint32_t)> happened)
    : loop_(loop),
      watched_(socket),
      events_(loop.context(), zmq::socket_type::pair),
      happened_(std::move(happened)) {
  static std::atomic<std::uint64_t> count{0};
  const std::string name = "inproc://events-" + std::to_string(++count);
  if (zmq_socket_monitor(socket.handle(), name.c_str(), events) != 0) throw zmq::error_t();
  events_.set(zmq::sockopt::linger, 0);
  events_.connect(name);
  loop_.watch(events_, [this] { read(); });
}

SocketMonitor::~SocketMonitor() {
  loop_.unwatch(events_);
  // First of all: ZeroMQ's thread would wait for ever to tell a monitor that nobody reads.
  zmq_socket_monitor(watched_.handle(), nullptr, 0);
}

void SocketMonitor::read() {
  while (true) {
    const Frames frames = receive(events_);
    if (frames.empty()) return;
    std::uint16_t event = 0;
    std::uint32_t value = 0;
    if (frames[0].size() < sizeof event + sizeof value) continue;
    const auto* bytes = static_cast<const char*>(frames[0].data());
    std::memcpy(&event, bytes, sizeof event);
    std::memcpy(&value, bytes + sizeof event, sizeof value);
    happened_(event, value);
  }
}

}  // namespace prehend::graph
