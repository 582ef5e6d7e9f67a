#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>

namespace prehend::graph {

/// A peer that speaks ZMTP 3.0 (ZeroMQ RFC 23) byte by byte, so that it can lie.
class RawPeer {
 public:
  /// `endpoint`: tcp://127.0.0.1:PORT.
  explicit RawPeer(const std::string& endpoint) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port =
        htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      ::close(socket_);
      throw std::runtime_error("cannot connect to " + endpoint);
    }
  }
  ~RawPeer() { ::close(socket_); }
  RawPeer(const RawPeer&) = delete;
  RawPeer& operator=(const RawPeer&) = delete;

  /// Greets as a DEALER without security and waits for the answer.
  bool shake_hands() {
    std::string greeting("\xff\0\0\0\0\0\0\0\0\x7f\x03\0NULL", 16);
    greeting.resize(64, '\0');
    send(greeting);
    if (receive(64).size() != 64) return false;
    const std::string ready(
        "\x04\x1a\x05READY\x0bSocket-Type\0\0\0\x06"
        "DEALER",
        2 + 6 + 12 + 4 + 6);
    std::string sized = ready;
    sized[1] = static_cast<char>(ready.size() - 2);
    send(sized);
    return !receive(2).empty();
  }
  void send(const std::string& bytes) {
    [[maybe_unused]] const auto sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  /// The head of a frame that is said to have `size` bytes, and to be the last of its message.
  void announce_frame(std::uint64_t size) {
    std::string head(1, '\x02');
    for (int shift = 56; shift >= 0; shift -= 8) head.push_back(static_cast<char>(size >> shift));
    send(head);
  }
  /// Whether the other side hangs up within `timeout`.
  bool is_hung_up(std::chrono::milliseconds timeout) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    while (std::chrono::steady_clock::now() < deadline) {
      pollfd item{socket_, POLLIN, 0};
      if (::poll(&item, 1, 50) <= 0) continue;
      char buffer[256];
      if (::recv(socket_, buffer, sizeof buffer, 0) <= 0) return true;
    }
    return false;
  }

 private:
  // Up to `size` bytes, less when they do not come within 2 s.
  std::string receive(std::size_t size) {
    std::string bytes;
    pollfd item{socket_, POLLIN, 0};
    while (bytes.size() < size && ::poll(&item, 1, 2000) > 0) {
      char buffer[64];
      const ssize_t got = ::recv(socket_, buffer, std::min(sizeof buffer, size - bytes.size()), 0);
      if (got <= 0) break;
      bytes.append(buffer, static_cast<std::size_t>(got));
    }
    return bytes;
  }

  int socket_;
};

/// Memory of this process that is resident [bytes].
inline std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace prehend::graph
