#include "msgs/convert/percepts.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

msgs::WrenchVector wrench_message(const belief::Wrench& wrench) {
  msgs::WrenchVector message;
  *message.mutable_force() = to_message(wrench.force);
  *message.mutable_torque() = to_message(wrench.torque);
  return message;
}

belief::Wrench read_wrench(const msgs::WrenchVector& message) {
  return {from_message(message.force()), from_message(message.torque())};
}

msgs::PadImage image_message(const belief::PadImage& image) {
  msgs::PadImage message;
  message.mutable_texels()->Assign(image.texels.begin(), image.texels.end());
  *message.mutable_center() = to_message(image.center_P);
  message.set_area(image.area);
  return message;
}

belief::PadImage read_image(const msgs::PadImage& message, const std::string& pad) {
  belief::PadImage image;
  image.texels.assign(message.texels().begin(), message.texels().end());
  for (const double texel : image.texels) {
    if (texel < 0) {
      throw InputError("Percepts of pad '" + pad + "' with a texel that pulls", kSenderMend);
    }
    image.force += texel;
  }
  image.center_P = from_message(message.center());
  image.area = message.area();
  if (image.area < 0) {
    throw InputError("Percepts of pad '" + pad + "' with a negative area", kSenderMend);
  }
  return image;
}

belief::PerceivedView read_view(const msgs::PerceivedView& message) {
  constexpr std::uint32_t kMostPixels = 4096;  // of a row or column
  if (message.width() > kMostPixels || message.height() > kMostPixels) {
    throw InputError("Percepts with a view of more than 4096 pixels a side", kSenderMend);
  }
  if (message.area() < 0) throw InputError("Percepts with a view of a negative area", kSenderMend);
  belief::PerceivedView view;
  view.depth = unpack_depth(message.depth(), static_cast<int>(message.width()),
                            static_cast<int>(message.height()));
  view.area = message.area();
  view.center_C = from_message(message.center());
  view.spread = from_message(message.spread()).head<2>();
  return view;
}

msgs::SenseSurprise sense_message(const belief::SenseSurprise& sense) {
  msgs::SenseSurprise message;
  message.set_sense(sense.sense);
  message.set_part(sense.part);
  message.set_bits(sense.bits);
  message.set_threshold(sense.threshold);
  message.set_alarm(sense.alarm);
  return message;
}

}  // namespace

msgs::Percepts to_message(const belief::Percepts& percepts) {
  msgs::Percepts message;
  for (const belief::PerceivedPad& pad : percepts.pads) {
    msgs::PerceivedPad& one = *message.add_pads();
    one.set_name(pad.name);
    *one.mutable_closed() = image_message(pad.at[belief::kClosed]);
    *one.mutable_lifted() = image_message(pad.at[belief::kLifted]);
    if (pad.touched_at) one.set_touched_at(*pad.touched_at);
  }
  for (const belief::PerceivedMotor& motor : percepts.motors) {
    msgs::PerceivedMotor& one = *message.add_motors();
    one.set_name(motor.name);
    if (const auto at = motor.at[belief::kClosed]) one.set_closed(*at);
    if (const auto at = motor.at[belief::kLifted]) one.set_lifted(*at);
    if (motor.stopped_after) one.set_stopped_after(*motor.stopped_after);
  }
  if (percepts.closing) *message.mutable_closing() = wrench_message(*percepts.closing);
  if (const auto& at = percepts.wrist[belief::kClosed]) {
    *message.mutable_closed() = wrench_message(*at);
  }
  if (const auto& at = percepts.wrist[belief::kLifted]) {
    *message.mutable_lifted() = wrench_message(*at);
  }
  if (percepts.weight) message.set_weight(*percepts.weight);
  if (percepts.view) *message.mutable_view() = to_message(*percepts.view);
  return message;
}

msgs::PerceivedView to_message(const belief::PerceivedView& view) {
  msgs::PerceivedView message;
  message.set_width(static_cast<std::uint32_t>(view.depth.width));
  message.set_height(static_cast<std::uint32_t>(view.depth.height));
  message.set_depth(pack_depth(view.depth));
  message.set_area(view.area);
  *message.mutable_center() = to_message(view.center_C);
  *message.mutable_spread() = to_message(Eigen::Vector3d(view.spread.x(), view.spread.y(), 0));
  return message;
}

belief::Percepts from_message(const msgs::Percepts& message) {
  belief::Percepts percepts;
  for (const msgs::PerceivedPad& one : message.pads()) {
    belief::PerceivedPad pad;
    pad.name = one.name();
    pad.at = {read_image(one.closed(), pad.name), read_image(one.lifted(), pad.name)};
    if (one.has_touched_at()) pad.touched_at = one.touched_at();
    percepts.pads.push_back(std::move(pad));
  }
  for (const msgs::PerceivedMotor& one : message.motors()) {
    belief::PerceivedMotor motor;
    motor.name = one.name();
    if (one.has_closed()) motor.at[belief::kClosed] = one.closed();
    if (one.has_lifted()) motor.at[belief::kLifted] = one.lifted();
    if (one.has_stopped_after()) motor.stopped_after = one.stopped_after();
    percepts.motors.push_back(std::move(motor));
  }
  if (message.has_closing()) percepts.closing = read_wrench(message.closing());
  if (message.has_closed()) percepts.wrist[belief::kClosed] = read_wrench(message.closed());
  if (message.has_lifted()) percepts.wrist[belief::kLifted] = read_wrench(message.lifted());
  if (message.has_weight()) percepts.weight = message.weight();
  if (message.has_view()) percepts.view = read_view(message.view());
  try {
    belief::check_percepts(percepts);
  } catch (const std::invalid_argument& error) {
    throw InputError(error.what(), kSenderMend);
  }
  return percepts;
}

msgs::PossiblePercepts to_message(const belief::PossiblePercepts& possible) {
  msgs::PossiblePercepts message;
  message.set_shape(possible.shape);
  message.set_along(possible.along);
  message.set_across(possible.across);
  message.set_weight(possible.weight);
  *message.mutable_percepts() = to_message(possible.percepts);
  return message;
}

msgs::PerceptForecast to_message(const belief::PerceptForecast& forecast) {
  msgs::PerceptForecast message;
  for (const belief::PossiblePercepts& one : forecast.possible) {
    *message.add_possible() = to_message(one);
  }
  message.mutable_problems()->Assign(forecast.problems.begin(), forecast.problems.end());
  return message;
}

msgs::PerceptSurprise to_message(const belief::PerceptSurprise& surprise,
                                 const belief::PerceptForecast& forecast,
                                 const belief::Percepts& perceived) {
  msgs::PerceptSurprise message;
  message.set_bits(surprise.bits);
  message.set_threshold(surprise.threshold);
  message.set_alarm(surprise.alarm);
  for (const belief::SenseSurprise& one : surprise.senses) {
    *message.add_senses() = sense_message(one);
  }
  for (const belief::SenseSurprise& one : surprise.parts) {
    *message.add_parts() = sense_message(one);
  }
  if (surprise.likeliest < forecast.possible.size()) {
    *message.mutable_likeliest() = to_message(forecast.possible[surprise.likeliest]);
  }
  *message.mutable_perceived() = to_message(perceived);
  return message;
}

}  // namespace prehend::convert
