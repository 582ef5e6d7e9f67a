#include "prehend/touch/pad_touch.h"

#include <algorithm>

#include "prehend/contact/pad_readings.h"

namespace prehend::touch {

PadTouch pad_touch(const FeltPad& pad, const std::vector<double>& counts,
                   const PadTouchOptions& options) {
  const FeltTexels felt = felt_texels(pad, counts);
  PadTouch touch;
  touch.texels = static_cast<int>(counts.size());
  touch.friction = options.friction > 0 ? options.friction : pad.law.dynamic_friction;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (felt.state[i] == Texel::kUnreadable) ++touch.unreadable;
    if (felt.force[i] <= 0) continue;
    ++touch.touched;
    if (felt.state[i] == Texel::kFull) ++touch.full;
    touch.area += pad.layout.area(i);
    touch.force += felt.force[i];
    touch.largest_pressure = std::max(touch.largest_pressure, felt.force[i] / pad.layout.area(i));
  }
  if (touch.touched == 0) {
    touch.not_determined = {touch.unreadable < touch.texels
                                ? "center, normal, curvature, holding_torque: nothing touches"
                                : "everything: no texel can be read"};
    return touch;
  }
  contact::PadState state(pad.layout);
  std::copy(felt.force.begin(), felt.force.end(), state.normal_force.begin());
  touch.center = contact::centre_of_pressure(pad.layout, state);
  ContactFit fit = fit_contact(pad, felt, *touch.center, options.fit);
  touch.normal = fit.normal;
  touch.curvature = fit.curvature;
  if (!fit.normal) touch.not_determined.push_back("normal: " + fit.no_normal);
  if (!fit.curvature) touch.not_determined.push_back("curvature: " + fit.no_curvature);
  if (touch.touched > 1) {
    touch.holding_torque = contact::holding_torque(pad.layout, state, touch.friction);
  } else {
    touch.not_determined.emplace_back("holding_torque: within one texel");
  }
  return touch;
}

}  // namespace prehend::touch
