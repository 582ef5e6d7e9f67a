#include "msgs/convert/touch.h"

#include <cstddef>
#include <cstdint>

#include "msgs/convert/geometry.h"

namespace prehend::convert {

void add_touch(const planning::PredictedTouch& touch, const robot::HandModel& hand,
               msgs::PredictedPercepts* percepts) {
  percepts->set_not_predicted(touch.problem);
  for (const double position : touch.stopped) percepts->add_stop_position(position);
  for (std::size_t i = 0; i < touch.pads.size(); ++i) {
    const planning::PredictedPad& pad = touch.pads[i];
    if (!(pad.sum > 0)) continue;
    const robot::TactilePadModel& model = hand.pads[i].model;
    msgs::PredictedPad& out = *percepts->add_pads();
    out.set_contact_area(pad.area);
    *out.mutable_center() = to_message(pad.center_P);
    msgs::TactileFrame& image = *out.mutable_image();
    image.mutable_header()->set_frame_id(pad.name);
    image.set_rows(static_cast<std::uint32_t>(pad.rows));
    image.set_columns(static_cast<std::uint32_t>(pad.columns));
    image.set_texel_width(model.texel_pitch);
    image.set_texel_height(model.texel_pitch);
    image.set_full_scale(static_cast<std::uint32_t>(model.full_scale));
    image.set_newton_per_count(model.newton_per_count);
    for (const std::uint16_t count : pad.counts) image.add_intensity(count);
    image.set_sum(pad.sum);
  }
}

}  // namespace prehend::convert
