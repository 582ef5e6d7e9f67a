#include "drivers/kuka_rsi/transport/udp_socket.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace prehend::drivers::kuka_rsi {
namespace {

Time wall_now() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::chrono::seconds(now.tv_sec) + Time(now.tv_nsec);
}

// The kernel stamps by the wall clock; what that jumps meanwhile is no age.
Time arrival_of(msghdr& message) {
  const Time now = steady_now();
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
    const Time age = wall_now() - (std::chrono::seconds(stamp.tv_sec) + Time(stamp.tv_nsec));
    if (age >= Time::zero() && age < std::chrono::seconds(10)) return now - age;
  }
  return now;
}

}  // namespace

std::string UdpPeer::name() const {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
  return std::string(text.data()) + ":" + std::to_string(ntohs(address.sin_port));
}

UdpPeer peer_at(const std::string& host, int port) {
  UdpPeer peer;
  peer.address.sin_family = AF_INET;
  peer.address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (inet_pton(AF_INET, host.c_str(), &peer.address.sin_addr) != 1) {
    throw geometry::InputError("'" + host + "' is no IPv4 address",
                               "Give it as 10.0.0.1, or 0.0.0.0 for all of this machine's");
  }
  return peer;
}

UdpSocket::UdpSocket(const std::string& host, int port) : here_(peer_at(host, port)) {
  descriptor_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int on = 1;
  ::setsockopt(descriptor_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  const auto* address = reinterpret_cast<const sockaddr*>(&here_.address);
  if (descriptor_ < 0 || ::bind(descriptor_, address, sizeof here_.address) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    const std::string what = "Cannot listen on UDP " + here_.name() + ": " + std::strerror(error);
    if (error == EADDRINUSE) {
      throw UdpPortTaken(what,
                         "Another program has it: stop that one, or take another port, here and in "
                         "the controller's RSI_EthernetConfig");
    }
    throw geometry::InputError(
        what, "Give an address of this machine (ip -4 address), and a port above 1023");
  }
  socklen_t size = sizeof here_.address;
  ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&here_.address), &size);
}

UdpSocket::~UdpSocket() { ::close(descriptor_); }

UdpSocket::Datagram UdpSocket::receive(std::span<char> buffer, Time end) {
  Datagram datagram;
  while (true) {
    iovec part{buffer.data(), buffer.size()};
    alignas(cmsghdr) std::array<char, 128> control{};
    msghdr message{};
    message.msg_name = &datagram.peer.address;
    message.msg_namelen = sizeof datagram.peer.address;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t count = ::recvmsg(descriptor_, &message, 0);
    if (count >= 0) {
      datagram.bytes = {buffer.data(), static_cast<std::size_t>(count)};
      datagram.arrived = arrival_of(message);
      datagram.came = true;
      return datagram;
    }
    const Time left = end - steady_now();
    if (left <= Time::zero()) return datagram;
    pollfd waiting{descriptor_, POLLIN, 0};
    const timespec span{static_cast<time_t>(left.count() / 1000000000),
                        static_cast<long>(left.count() % 1000000000)};
    ::ppoll(&waiting, 1, &span, nullptr);
  }
}

bool UdpSocket::send(std::string_view bytes, const UdpPeer& peer) {
  const auto* address = reinterpret_cast<const sockaddr*>(&peer.address);
  return ::sendto(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL, address,
                  sizeof peer.address) == static_cast<ssize_t>(bytes.size());
}

}  // namespace prehend::drivers::kuka_rsi
