#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/contact/pad_layout.h"
#include "prehend/text/knob.h"

// How a hand closes on a thing and presses, and what its pads then say: the same for the cycle that
// does it and for the simulation that predicts it.
namespace prehend::robot {

/// One pad as felt.
struct PadPercept {
  double sum = 0;   // N
  double area = 0;  // m^2, of the texels above the touch threshold
  double age = 0;   // s, of the frame
  std::string name{};
};

inline constexpr int kTouchCounts = 10;  // above: a texel is touched

/// Area [m^2] of the texels, `texel_area` [m^2] each, that show more than `threshold` counts.
template <class Counts>
double touched_area(const Counts& counts, int threshold, double texel_area) {
  int touched = 0;
  for (const auto count : counts) {
    if (static_cast<long>(count) > threshold) ++touched;
  }
  return touched * texel_area;
}

/// The same of a pad whose texels are those of `layout`. @pre counts has as many.
template <class Counts>
double touched_area(const Counts& counts, int threshold, const contact::PadLayout& layout) {
  double area = 0;
  std::size_t i = 0;
  for (const auto count : counts) {
    if (static_cast<long>(count) > threshold) area += layout.area(i);
    ++i;
  }
  return area;
}

/// What the pads that touch feel.
struct MeanTouch {
  int pads = 0;
  double sum = 0;   // N, mean of those
  double area = 0;  // m^2, mean of those
};

/// Of the pads with a frame no older than `stale_time` [s], those that feel more than `touch_force`
/// [N].
MeanTouch mean_touch(const std::vector<PadPercept>& pads, double touch_force, double stale_time);

struct GripOptions {
  double closing_speed = 0.3;
  double gather = 0.1;       // rad: one that touches long before the others would push the object
  double overrun = 0.5;      // rad: predicted shapes are too large or small
  double grip_force = 0;     // N
  double touch_force = 0.3;  // N
  double force_timeout = 4;  // s
  double settle_time = 0.3;  // s

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"closing_speed", self.closing_speed, "", 0.01, 1,
               "of fingers, share of the joints' greatest"});
    visit(Knob{"gather", self.gather, "rad", 0, 3.2,
               "fingers first go to where they are predicted to be this much before they touch, "
               "and close from there together"});
    visit(Knob{
        "overrun", self.overrun, "rad", 0, 3.2,
        "how far fingers go on beyond where they were predicted to touch, within their limits"});
    visit(Knob{"grip_force", self.grip_force, "N", 0, 1000,
               "that the pads of fingers which touch are to feel, their mean, where the plan says "
               "no force; 0: as the motors press"});
    visit(Knob{"touch_force", self.touch_force, "N", 0.01, 100, "of a pad's sum that touches"});
    visit(Knob{"force_timeout", self.force_timeout, "s", 0.1, 60,
               "for fingers to reach the force; then it is gripped with what there is"});
    visit(Knob{"settle_time", self.settle_time, "s", 0, 10, "after fingers have closed"});
  }

  /// @throws std::invalid_argument naming the field, after `of`.
  void validate(std::string_view of = "GripOptions.") const;
};

inline constexpr double kPressTime = 0.15;  // s, until what is felt has followed the effort

/// Motors that hold do not give way when they are told to press less. Therefore they begin with
/// less than the share of their greatest effort that is thought to be enough, in (0, 1], ...
double first_effort_share(double enough);
/// ... and are told more, step by step, until the pads' mean is `wanted` [N]: the share to go on
/// with; none when it is enough or all that there is.
std::optional<double> next_effort_share(double share, const MeanTouch& felt, double wanted);

}  // namespace prehend::robot
