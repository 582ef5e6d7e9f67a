#include "drivers/sdh/node/hand_axes.h"

#include "drivers/sdh/driver/driver.h"

namespace prehend::drivers::sdh {

HandAxes hand_axes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   double most_current) {
  const Limits limits = sdh2_limits();
  DeviceAxes device{"an SDH-2", "SDH-2", "kr5_sdh", {}, {}, {}, {}};
  device.lower.assign(limits.lower.begin(), limits.lower.end());
  device.upper.assign(limits.upper.begin(), limits.upper.end());
  device.speed.assign(limits.max_speed.begin(), limits.max_speed.end());
  device.current.assign(kAxes, most_current);
  return {platform, joints, device};
}

}  // namespace prehend::drivers::sdh
