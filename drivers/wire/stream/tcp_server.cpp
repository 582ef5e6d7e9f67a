#include "drivers/wire/stream/tcp_server.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "prehend/geometry/errors.h"

namespace prehend::drivers {

TcpServer::TcpServer(std::uint16_t port) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 4) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    const std::string words = std::strerror(errno);
    ::close(listener_);
    throw geometry::InputError("cannot listen on port " + std::to_string(port) + ": " + words,
                               "Choose another port, or 0 for any");
  }
  name_ = "tcp://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

TcpServer::~TcpServer() {
  disconnect();
  ::close(listener_);
}

void TcpServer::disconnect() {
  if (client_ >= 0) ::close(client_);
  client_ = -1;
}

IoResult TcpServer::read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) {
  if (client_ < 0) {
    pollfd file{listener_, POLLIN, 0};
    const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(timeout);
    ::poll(&file, 1, static_cast<int>(wait.count()));
    client_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client_ < 0) return {};
    const int on = 1;
    ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return {};
  }
  IoResult result = read_descriptor(client_, buffer, timeout);
  if (result.status == IoStatus::kClosed) {
    disconnect();
    result.status = IoStatus::kTimeout;  // another client may come
  }
  return result;
}

IoResult TcpServer::write(Bytes bytes, std::chrono::nanoseconds timeout) {
  if (client_ < 0) return {IoStatus::kOk, bytes.size(), {}};
  IoResult result = write_descriptor(client_, bytes, timeout);
  if (result.status == IoStatus::kClosed) disconnect();
  return result;
}

}  // namespace prehend::drivers
