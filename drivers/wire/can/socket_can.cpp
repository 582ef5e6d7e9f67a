#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/can/can_interface.h"
#include "drivers/wire/can/raw_frame.h"
#include "drivers/wire/can/slcan.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers {
namespace {

using Kind = CanEvent::Kind;

/// A raw socket of Linux' SocketCAN, bound to one interface. It survives the interface going down
/// and up; when the interface is removed it has to be opened anew.
class SocketCan : public CanBus {
 public:
  SocketCan(std::string name, const std::vector<std::uint16_t>& identifiers)
      : name_(std::move(name)),
        descriptor_(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW)) {
    if (descriptor_ < 0) {
      throw geometry::InputError("this kernel offers no CAN sockets (" + problem() + ")",
                                 "Load them with 'sudo modprobe can-raw', or use a kernel that has "
                                 "CAN, or a serial adapter as slcan:/dev/ttyACM0");
    }
    const can_err_mask_t errors = CAN_ERR_MASK;
    ::setsockopt(descriptor_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
    std::vector<can_filter> filters;
    for (const std::uint16_t identifier : identifiers) {
      filters.push_back({identifier, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG});
    }
    if (!filters.empty()) {
      ::setsockopt(descriptor_, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(filters.size() * sizeof(can_filter)));
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(name_.c_str()));
    if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      const std::string words = problem();
      ::close(descriptor_);
      throw geometry::InputError("cannot use CAN interface " + name_ + ": " + words,
                                 "Check 'ip -details link show " + name_ + "'");
    }
  }
  ~SocketCan() override { ::close(descriptor_); }
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  std::optional<CanInput> receive(std::chrono::nanoseconds timeout) override {
    const timespec wait{std::chrono::duration_cast<std::chrono::seconds>(timeout).count(),
                        (timeout % std::chrono::seconds(1)).count()};
    pollfd file{descriptor_, POLLIN, 0};
    if (::ppoll(&file, 1, &wait, nullptr) <= 0) return std::nullopt;
    can_frame raw{};
    const ssize_t size = ::read(descriptor_, &raw, sizeof raw);
    if (size < 0) {
      if (errno == EAGAIN || errno == EINTR) return std::nullopt;
      if (errno == ENETDOWN) return CanEvent{Kind::kInterfaceDown, name_ + " went down"};
      return CanEvent{Kind::kClosed, name_ + " is gone: " + problem()};
    }
    if (size != sizeof raw) return CanEvent{Kind::kDisturbed, "a frame of odd size"};
    return input_of(raw);
  }

  std::string send(const CanFrame& frame) override {
    const can_frame raw = raw_frame_of(frame);
    constexpr int kTries = 5;  // a full queue of a slow bus empties within some frames' time
    for (int i = 0; i < kTries; ++i) {
      if (::write(descriptor_, &raw, sizeof raw) == sizeof raw) return {};
      if (errno != ENOBUFS && errno != EAGAIN) break;
      ::usleep(1000);
    }
    if (errno == ENOBUFS) return name_ + ": the send queue is full, as nothing leaves the bus";
    return name_ + ": " + problem();
  }

  const std::string& name() const override { return name_; }

 private:
  static std::string problem() { return std::strerror(errno); }

  std::string name_;
  int descriptor_;
};

}  // namespace

std::unique_ptr<CanBus> open_can_bus(const std::string& name, unsigned bit_rate,
                                     const std::vector<std::uint16_t>& identifiers) {
  constexpr std::string_view kSlcan = "slcan:";
  if (name.starts_with(kSlcan)) {
    return std::make_unique<Slcan>(open_byte_stream(name.substr(kSlcan.size()), 115200), bit_rate,
                                   identifiers);
  }
  if (!kernel_has_can()) return std::make_unique<SocketCan>(name, identifiers);  // says so
  const auto interface = find_can_interface(name);
  if (!interface) {
    throw geometry::InputError("there is no CAN interface " + name,
                               "List them with 'ip link show type can'; plug the adapter in");
  }
  const std::string rate = std::to_string(bit_rate > 0 ? bit_rate : 500000);
  const std::string set_up = "sudo ip link set " + name + " up" +
                             (interface->kind == "can" ? " type can bitrate " + rate : "");
  if (!interface->is_up) {
    throw geometry::InputError("CAN interface " + name + " is down",
                               "Bring it up with '" + set_up + "'");
  }
  if (bit_rate > 0 && interface->bit_rate > 0 && interface->bit_rate != bit_rate) {
    throw geometry::InputError(
        "CAN interface " + name + " runs at " + std::to_string(interface->bit_rate) +
            " bit/s, not " + rate,
        "Set it with 'sudo ip link set " + name + " down' and '" + set_up + "'");
  }
  return std::make_unique<SocketCan>(name, identifiers);
}

}  // namespace prehend::drivers
