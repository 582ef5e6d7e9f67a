#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace prehend::testing {

/// A viewer, as far as tests need one: blocking, each call in at most 10 s.
class WebSocketClient {
 public:
  struct Frame {
    bool is_text = false;
    std::string bytes;
  };
  struct Options {
    std::string subprotocols = "foxglove.websocket.v1";
    std::string target = "/";
    std::map<std::string, std::string> headers;
    int receive_buffer = 0;  ///< bytes of the socket's; 0: the system's
  };

  /// @throws std::runtime_error with the answer's status and words when it is refused.
  explicit WebSocketClient(std::uint16_t port);
  WebSocketClient(std::uint16_t port, const Options& options);
  ~WebSocketClient();

  const std::string& subprotocol() const;
  void send_text(const std::string& text);
  void send_binary(const std::string& bytes);
  /// The next frame; nothing when none came, or the connection ended.
  std::optional<Frame> receive(std::chrono::milliseconds timeout = std::chrono::seconds(10));
  /// Why the server closed it, once receive() gave nothing.
  std::string close_reason() const;
  int close_code() const;
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a plain HTTP request is answered with.
struct HttpAnswer {
  int status = 0;
  std::map<std::string, std::string> headers;  ///< by lower-case names
  std::string body;
};
/// `request` is sent as it is. @throws std::runtime_error when no answer comes.
HttpAnswer http(std::uint16_t port, const std::string& request);
HttpAnswer http_get(std::uint16_t port, const std::string& target);

}  // namespace prehend::testing
