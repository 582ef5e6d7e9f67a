#include "drivers/barrett/node/hand_axes.h"

#include "drivers/barrett/driver/driver.h"

namespace prehend::drivers::barrett {

HandAxes hand_axes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   const Gearing& gearing, double most_torque) {
  const Limits limits = bh8_limits(gearing);
  DeviceAxes device{"a BH8-280", "BH8-280", "pa10_barrett", {}, {}, {}, {}};
  device.lower.assign(limits.lower.begin(), limits.lower.end());
  device.upper.assign(limits.upper.begin(), limits.upper.end());
  device.speed.assign(limits.max_speed.begin(), limits.max_speed.end());
  device.current.assign(kAxes, most_torque);
  return {platform, joints, device};
}

}  // namespace prehend::drivers::barrett
