#include "drivers/barrett/codec/axes.h"

namespace prehend::drivers::barrett {

const char* axis_name(std::size_t axis) {
  constexpr const char* kAxisNames[kAxes] = {"F1", "F2", "F3", "spread"};
  return axis < kAxes ? kAxisNames[axis] : "?";
}

}  // namespace prehend::drivers::barrett
