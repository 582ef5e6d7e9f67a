#include "msgs/convert/pad_touch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "msgs/convert/geometry.h"

namespace prehend::convert {
namespace {

char slip_character(touch::TexelSlip slip) {
  switch (slip) {
    case touch::TexelSlip::kFree:
      return '.';
    case touch::TexelSlip::kSticks:
      return '=';
    case touch::TexelSlip::kSlips:
      return '>';
    case touch::TexelSlip::kUnknown:
      break;
  }
  return '?';
}

}  // namespace

touch::FeltPad felt_pad(const msgs::TactileFrame& frame, const robot::HandPad& of, bool mirrored) {
  const std::uint64_t texels = std::uint64_t{frame.rows()} * frame.columns();
  if (texels == 0 || static_cast<std::uint64_t>(frame.intensity_size()) != texels) {
    throw std::invalid_argument("a tactile frame of " + std::to_string(frame.rows()) + " x " +
                                std::to_string(frame.columns()) + " texels has " +
                                std::to_string(frame.intensity_size()) + " counts");
  }
  const double npc = frame.newton_per_count();
  if (!(std::isfinite(npc) && npc > 0) || frame.full_scale() == 0) {
    throw std::invalid_argument(
        "a tactile frame must say newton_per_count and full_scale, both above 0");
  }
  if (!of.layout->is_flat()) {
    if (texels != of.layout->size()) {
      throw std::invalid_argument("a tactile frame of " + std::to_string(texels) +
                                  " counts is none of pad '" + of.name + "', which has " +
                                  std::to_string(of.layout->size()) + " cells");
    }
    return {*of.layout, of.model.law, npc, static_cast<int>(frame.full_scale())};
  }
  contact::PadGrid grid;
  grid.rows = static_cast<int>(frame.rows());
  grid.columns = static_cast<int>(frame.columns());
  grid.width = frame.columns() * frame.texel_width();
  grid.length = frame.rows() * frame.texel_height();
  grid.thickness = of.model.thickness;
  touch::FeltPad pad = touch::felt_pad(grid, of.model, mirrored);
  pad.newton_per_count = npc;
  pad.full_scale = static_cast<int>(frame.full_scale());
  return pad;
}

std::vector<double> counts_of(const msgs::TactileFrame& frame) {
  return {frame.intensity().begin(), frame.intensity().end()};
}

msgs::PadTouch to_message(const std::string& pad, const touch::PadTouch& touch) {
  msgs::PadTouch message;
  message.set_pad(pad);
  message.set_texels(static_cast<std::uint32_t>(touch.texels));
  message.set_touched(static_cast<std::uint32_t>(touch.touched));
  message.set_full(static_cast<std::uint32_t>(touch.full));
  message.set_area(touch.area);
  message.set_force(touch.force);
  message.set_largest_pressure(touch.largest_pressure);
  if (touch.center) *message.mutable_center() = to_message(*touch.center);
  if (touch.normal) {
    *message.mutable_normal()->mutable_direction() = to_message(touch.normal->direction);
    message.mutable_normal()->set_deviation(touch.normal->deviation);
  }
  if (touch.curvature) {
    msgs::PadTouch::Curvature& curvature = *message.mutable_curvature();
    curvature.set_largest(touch.curvature->largest);
    curvature.set_smallest(touch.curvature->smallest);
    *curvature.mutable_direction() = to_message(touch.curvature->direction);
    curvature.set_deviation(touch.curvature->deviation);
  }
  if (touch.holding_torque) {
    message.set_holding_torque(*touch.holding_torque);
    message.set_friction(touch.friction);
  }
  for (const std::string& reason : touch.not_determined) message.add_not_determined(reason);
  return message;
}

void add_slip(const touch::SlipReading& slip, int columns, msgs::PadTouch* message) {
  if (message->touched() == 0) return;  // nothing that could slip, as is said already
  msgs::PadTouch::Slip& out = *message->mutable_slip();
  const auto count = static_cast<int>(slip.texels.size());
  for (int begin = 0; begin < count; begin += columns) {
    std::string* row = out.mutable_texels()->add_rows();
    for (int i = begin; i < std::min(begin + columns, count); ++i) {
      row->push_back(slip_character(slip.texels[i]));
    }
  }
  if (!slip.determined) {
    message->add_not_determined("slip: " + slip.reason);
    return;
  }
  out.set_basis(msgs::PadTouch::Slip::PATTERN);
  out.set_slipping(static_cast<std::uint32_t>(slip.slipping));
  out.set_duration(slip.duration);
  *out.mutable_shift() = to_message(Eigen::Vector3d(slip.shift.x(), slip.shift.y(), 0));
  out.set_turn(slip.turn);
  out.set_deviation(slip.deviation);
}

}  // namespace prehend::convert
