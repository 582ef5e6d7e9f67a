#pragma once

namespace prehend::drivers {

/// What happened to what a port is open on, apart from data.
enum class PortEvent {
  kRemark,
  kDown,    ///< nothing is sent or received until kUp
  kUp,      ///< it is back
  kClosed,  ///< it is gone; open it anew
};

}  // namespace prehend::drivers
