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

msgs::TactileCells cells_message(const robot::HandModel& hand) {
  msgs::TactileCells message;
  for (const robot::HandPad& pad : hand.pads) {
    const contact::PadLayout& layout = *pad.layout;
    msgs::PadCells& out = *message.add_pads();
    out.set_name(pad.name);
    out.set_link(hand.model.links[static_cast<std::size_t>(pad.link)].name);
    *out.mutable_x_lp() = to_message(pad.X_LP);
    out.set_rows(static_cast<std::uint32_t>(pad.model.rows));
    out.set_columns(static_cast<std::uint32_t>(pad.model.columns));
    out.set_thickness(layout.thickness());
    for (std::size_t i = 0; i < layout.size(); ++i) {
      for (const double x : layout.position(i)) out.add_position(x);
      for (const double x : layout.normal(i)) out.add_normal(x);
      out.add_area(layout.area(i));
    }
  }
  return message;
}

}  // namespace prehend::convert
