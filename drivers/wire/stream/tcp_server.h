#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers {

/// The device's end of an emulated TCP connection: listens on this host's loopback interface and
/// serves one client at a time. While there is none, nothing is read and what is written is lost.
/// For one thread.
class TcpServer : public ByteStream {
 public:
  /// `port` 0: any free one. @throws geometry::InputError when the port is taken.
  explicit TcpServer(std::uint16_t port = 0);
  ~TcpServer() override;

  /// "tcp://127.0.0.1:PORT"
  const std::string& name() const override { return name_; }
  /// Closes the connection to the client.
  void disconnect();

  IoResult read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) override;
  IoResult write(Bytes bytes, std::chrono::nanoseconds timeout) override;

 private:
  int listener_ = -1;
  int client_ = -1;
  std::string name_;
};

}  // namespace prehend::drivers
