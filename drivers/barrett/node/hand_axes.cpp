#include "drivers/barrett/node/hand_axes.h"

#include "drivers/barrett/driver/driver.h"
#include "drivers/barrett/driver/gcl/driver.h"

namespace prehend::drivers::barrett {

HandAxes hand_axes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   Model model, const Gearing& gearing, double most_torque) {
  const bool is_280 = model == Model::kBh8_280;
  const Limits limits = is_280 ? bh8_limits(gearing) : gcl::bh8_262_limits(gearing);
  const std::string name = is_280 ? "BH8-280" : "BH8-262";
  DeviceAxes device{"a " + name, name, "pa10_barrett", {}, {}, {}, {}};
  device.lower.assign(limits.lower.begin(), limits.lower.end());
  device.upper.assign(limits.upper.begin(), limits.upper.end());
  device.speed.assign(limits.max_speed.begin(), limits.max_speed.end());
  device.current.assign(kAxes, most_torque);
  return {platform, joints, device};
}

}  // namespace prehend::drivers::barrett
