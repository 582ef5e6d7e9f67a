#include "drivers/wire/can/raw_frame.h"

#include <linux/can/error.h>

#include <algorithm>

namespace prehend::drivers {
namespace {

using Kind = CanEvent::Kind;

CanEvent event_of_controller(std::uint8_t status) {
  if (status & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) {
    return {Kind::kDisturbed, "frames were lost in the controller"};
  }
  if (status & CAN_ERR_CRTL_ACTIVE) {
    return {Kind::kRestarted, "the controller counts no more errors"};
  }
  const bool is_passive = status & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE);
  return {Kind::kDisturbed, is_passive ? "many errors on the wire: the controller is error-passive"
                                       : "the controller counts errors on the wire"};
}

CanEvent event_of(const can_frame& raw) {
  if (raw.can_id & CAN_ERR_BUSOFF) {
    return {Kind::kBusOff, "bus-off: too many errors on the wire (termination, bit rate, wiring)"};
  }
  if (raw.can_id & CAN_ERR_RESTARTED) return {Kind::kRestarted, "the controller was restarted"};
  if (raw.can_id & CAN_ERR_ACK) {
    return {Kind::kDisturbed, "nobody acknowledges frames: is the device on, the bit rate right?"};
  }
  if (raw.can_id & CAN_ERR_CRTL) return event_of_controller(raw.data[1]);
  return {Kind::kDisturbed, "errors on the wire"};
}

}  // namespace

std::optional<CanInput> input_of(const can_frame& raw) {
  if (raw.can_id & CAN_ERR_FLAG) return event_of(raw);
  if (raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) return std::nullopt;
  CanFrame frame{.identifier = static_cast<std::uint16_t>(raw.can_id & CAN_SFF_MASK),
                 .size = std::min<std::uint8_t>(raw.can_dlc, CAN_MAX_DLEN)};
  std::copy_n(raw.data, frame.size, frame.data.begin());
  return frame;
}

can_frame raw_frame_of(const CanFrame& frame) {
  can_frame raw{};
  raw.can_id = frame.identifier;
  raw.can_dlc = frame.size;
  std::copy_n(frame.data.begin(), frame.size, raw.data);
  return raw;
}

}  // namespace prehend::drivers
