#pragma once

#include <cstdint>
#include <functional>

#include <zmq.hpp>

#include "prehend/graph/link/io_loop.h"

namespace prehend::graph {

/// Tells of a socket's connections: ZMQ_EVENT_... with its value. In the loop's thread only, and
/// never alive when the socket is closed.
class SocketMonitor {
 public:
  SocketMonitor(IoLoop& loop, zmq::socket_ref socket, int events,
                std::function<void(std::uint16_t event, std::uint32_t value)> happened);
  ~SocketMonitor();
  SocketMonitor(const SocketMonitor&) = delete;
  SocketMonitor& operator=(const SocketMonitor&) = delete;

 private:
  void read();

  IoLoop& loop_;
  zmq::socket_ref watched_;
  zmq::socket_t events_;
  std::function<void(std::uint16_t, std::uint32_t)> happened_;
};

}  // namespace prehend::graph
