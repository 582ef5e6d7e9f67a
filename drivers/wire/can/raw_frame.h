#pragma once

#include <linux/can.h>

#include <optional>

#include "drivers/wire/can/can_bus.h"

namespace prehend::drivers {

/// What a frame of Linux' SocketCAN says: data, or (CAN_ERR_FLAG) what happened to the bus, by the
/// classes and bytes of linux/can/error.h. Where several classes are set the gravest counts.
/// Nothing for extended and remote frames, which nobody here sends.
std::optional<CanInput> input_of(const can_frame& raw);

/// The other way; data frames only.
can_frame raw_frame_of(const CanFrame& frame);

}  // namespace prehend::drivers
