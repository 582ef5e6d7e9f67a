#pragma once

#include <netinet/in.h>

#include <span>
#include <string>
#include <string_view>

#include "drivers/wire/time/time.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::kuka_rsi {

/// Where a datagram comes from or goes to.
struct UdpPeer {
  sockaddr_in address{};

  friend bool operator==(const UdpPeer& a, const UdpPeer& b) {
    return a.address.sin_addr.s_addr == b.address.sin_addr.s_addr &&
           a.address.sin_port == b.address.sin_port;
  }
  /// "10.0.0.2:6008".
  std::string name() const;
};

/// @throws geometry::InputError where `host` is no IPv4 address.
UdpPeer peer_at(const std::string& host, int port);

/// Another program has the port.
class UdpPortTaken : public geometry::InputError {
 public:
  using InputError::InputError;
};

/// A UDP socket. After its making it allocates nothing.
class UdpSocket {
 public:
  /// Binds to the IPv4 address `host`, "0.0.0.0" for all, and `port`; 0: any free one.
  /// @throws geometry::InputError naming the port and the mend: no such address, no permission;
  /// UdpPortTaken.
  UdpSocket(const std::string& host, int port);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  struct Datagram {
    std::string_view bytes;  // of the buffer; longer ones are cut there
    UdpPeer peer;
    Time arrived{};  // at this machine, by its kernel; of steady_now()
    bool came = false;
  };
  /// The next datagram, for which it waits until `end`.
  Datagram receive(std::span<char> buffer, Time end);
  /// False where the network does not take it.
  bool send(std::string_view bytes, const UdpPeer& peer);
  /// What it is bound to.
  const UdpPeer& here() const { return here_; }

 private:
  int descriptor_ = -1;
  UdpPeer here_;
};

}  // namespace prehend::drivers::kuka_rsi
