#include "msgs/convert/tactile_cells.h"

#include <cstddef>
#include <cstdint>

#include "msgs/convert/geometry.h"

namespace prehend::convert {

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
