#include "drivers/wire/can/can_interface.h"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <functional>
#include <stdexcept>

namespace prehend::drivers {
namespace {

constexpr const char* kStates[] = {"error-active", "error-warning", "error-passive",
                                   "bus-off",      "stopped",       "sleeping"};

// Calls back for each attribute in `size` bytes at `first`.
void for_each_attribute(const rtattr* first, int size,
                        const std::function<void(int type, const rtattr*)>& take) {
  for (const rtattr* a = first; RTA_OK(a, size); a = RTA_NEXT(a, size)) {
    take(a->rta_type & NLA_TYPE_MASK, a);
  }
}

template <class Value>
Value value_of(const rtattr* attribute) {
  Value value{};
  std::memcpy(&value, RTA_DATA(attribute),
              std::min<std::size_t>(sizeof value, RTA_PAYLOAD(attribute)));
  return value;
}

void read_link_information(const rtattr* information, CanInterface& interface) {
  for_each_attribute(static_cast<const rtattr*>(RTA_DATA(information)), RTA_PAYLOAD(information),
                     [&](int type, const rtattr* a) {
                       if (type == IFLA_INFO_KIND)
                         interface.kind = static_cast<const char*>(RTA_DATA(a));
                       if (type != IFLA_INFO_DATA) return;
                       for_each_attribute(static_cast<const rtattr*>(RTA_DATA(a)), RTA_PAYLOAD(a),
                                          [&](int of_can, const rtattr* b) {
                                            if (of_can == IFLA_CAN_BITTIMING) {
                                              interface.bit_rate =
                                                  value_of<can_bittiming>(b).bitrate;
                                            }
                                            if (of_can == IFLA_CAN_STATE) {
                                              const auto state = value_of<std::uint32_t>(b);
                                              if (state < std::size(kStates))
                                                interface.state = kStates[state];
                                            }
                                          });
                     });
}

class Socket {
 public:
  Socket(int family, int type, int protocol)
      : descriptor_(::socket(family, type | SOCK_CLOEXEC, protocol)) {}
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace

std::optional<CanInterface> find_can_interface(const std::string& name) {
  const unsigned index = ::if_nametoindex(name.c_str());
  if (index == 0) return std::nullopt;
  const Socket socket(AF_NETLINK, SOCK_RAW, NETLINK_ROUTE);
  struct {
    nlmsghdr header;
    ifinfomsg message;
  } request{};
  request.header.nlmsg_len = NLMSG_LENGTH(sizeof request.message);
  request.header.nlmsg_type = RTM_GETLINK;
  request.header.nlmsg_flags = NLM_F_REQUEST;
  request.message.ifi_family = AF_UNSPEC;
  request.message.ifi_index = static_cast<int>(index);
  alignas(nlmsghdr) std::array<char, 16384> buffer;
  ssize_t size = -1;
  if (socket.get() >= 0 && ::send(socket.get(), &request, request.header.nlmsg_len, 0) >= 0) {
    size = ::recv(socket.get(), buffer.data(), buffer.size(), 0);
  }
  const auto* header = reinterpret_cast<const nlmsghdr*>(buffer.data());
  if (size < 0 || !NLMSG_OK(header, static_cast<std::size_t>(size)) ||
      header->nlmsg_type != RTM_NEWLINK) {
    throw std::runtime_error("the kernel does not tell about network interface " + name);
  }
  const auto* link = static_cast<const ifinfomsg*>(NLMSG_DATA(header));
  CanInterface interface;
  interface.is_up = link->ifi_flags & IFF_UP;
  for_each_attribute(IFLA_RTA(link), static_cast<int>(IFLA_PAYLOAD(header)),
                     [&](int type, const rtattr* a) {
                       if (type == IFLA_LINKINFO) read_link_information(a, interface);
                     });
  return interface;
}

bool kernel_has_can() { return Socket(PF_CAN, SOCK_RAW, CAN_RAW).get() >= 0; }

}  // namespace prehend::drivers
