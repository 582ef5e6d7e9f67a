#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "prehend/viewing/access.h"
#include "prehend/viewing/hub.h"
#include "prehend/viewing/types.h"

namespace prehend::viewing {

struct ServerOptions {
  std::string name = "prehend";       ///< what viewers show
  std::string address = "127.0.0.1";  ///< to listen at
  std::uint16_t port = 8765;          ///< 0: any that is free
  std::string token;                  ///< needed beyond loopback, see AccessRules
  std::vector<std::string> allowed_origins;
  std::filesystem::path page;                           ///< folder of the page's files
  std::size_t most_viewers = 64;                        ///< further ones are refused
  std::size_t most_frame_bytes = std::size_t{4} << 20;  ///< of what a viewer sends
  std::chrono::milliseconds idle_timeout{30000};  ///< pinged at half of it; silent so long: gone
  ViewerLimits limits;
};

/// One port for HTTP (the files of the page) and the Foxglove WebSocket protocol, version 1, in
/// both its sub-protocols: what our own page, Foxglove and Lichtblick connect to. One thread of its
/// own serves all; the functions here may be called from any thread and wait for nobody. See Hub
/// for what viewers get.
class Server {
 public:
  /// Listens at once. @throws std::runtime_error naming address, port and mend when it cannot, and
  /// for an address beyond loopback without a token.
  Server(const ServerOptions& options, Handlers handlers);
  /// Tells viewers that it goes. Nobody may be about to answer a handler any more.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  /// "http://127.0.0.1:8765/", with the token where there is one.
  std::string page_address() const;

  ChannelId add_channel(Channel channel);
  void remove_channel(ChannelId id);
  ServiceId add_service(ServiceType service);
  void remove_service(ServiceId id);
  /// See Hub. The payload is shared, not copied.
  void publish(ChannelId id, std::uint64_t time, Payload payload, std::string sender = "");
  void set_time(std::uint64_t time);
  void set_graph(ConnectionGraph graph);
  void publish_parameters(std::vector<Parameter> parameters);
  void tell(StatusLevel level, std::string message, std::string id = "");
  /// Now, as far as the server's thread knows.
  std::size_t viewers() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace prehend::viewing
