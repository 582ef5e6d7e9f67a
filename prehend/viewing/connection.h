#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <list>

#include <boost/asio/ip/tcp.hpp>

#include "prehend/viewing/access.h"
#include "prehend/viewing/hub.h"
#include "prehend/viewing/server.h"

namespace prehend::viewing {

/// The connections that there are. In the server's thread, but for viewers().
class ConnectionCount {
 public:
  using Close = std::function<void()>;
  using Place = std::list<Close>::iterator;

  Place add(Close close, bool is_viewer) {
    if (is_viewer) ++viewers_;
    return connections_.insert(connections_.end(), std::move(close));
  }
  void remove(Place place, bool is_viewer) {
    if (is_viewer) --viewers_;
    connections_.erase(place);
    if (connections_.empty() && on_empty) on_empty();
  }
  /// Asks each to end.
  void close_all() {
    const std::list<Close> all = connections_;
    for (const Close& close : all) close();
  }
  bool empty() const { return connections_.empty(); }
  std::size_t size() const { return connections_.size(); }
  std::size_t viewers() const { return viewers_; }

  std::function<void()> on_empty;

 private:
  std::list<Close> connections_;
  std::atomic<std::size_t> viewers_{0};
};

/// Answers requests for the page's files, and goes on as a viewer of `hub` when the peer asks for a
/// WebSocket and may have one. Everything must outlive it, and all runs in the socket's thread.
void serve_connection(boost::asio::ip::tcp::socket socket, Hub& hub, const ServerOptions& options,
                      const AccessRules& rules, ConnectionCount& connections);

}  // namespace prehend::viewing
