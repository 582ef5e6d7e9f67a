#include "msgs/convert/load_bounds.h"

#include <cmath>

#include <fmt/format.h>

#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {

msgs::Interval to_message(const grasp::Interval& interval) {
  msgs::Interval message;
  if (interval.low > 0) message.set_low(interval.low);
  if (std::isfinite(interval.high)) message.set_high(interval.high);
  return message;
}

grasp::Interval from_message(const msgs::Interval& message, const char* what) {
  grasp::Interval interval;
  if (message.has_low()) interval.low = message.low();
  if (message.has_high()) interval.high = message.high();
  const bool high_is_number = !message.has_high() || std::isfinite(message.high());
  if (std::isfinite(interval.low) && interval.low >= 0 && high_is_number && interval.high > 0 &&
      !interval.is_empty()) {
    return interval;
  }
  throw geometry::InputError(
      fmt::format("An object with {} of {} to {}", what, interval.low, interval.high), kSenderMend);
}

grasp::LoadBounds load_of(const msgs::ObjectModel& model) {
  grasp::LoadBounds load;
  if (model.has_mass()) load.mass = from_message(model.mass(), "a mass");
  if (model.has_friction()) load.friction = from_message(model.friction(), "a friction");
  return load;
}

}  // namespace prehend::convert
