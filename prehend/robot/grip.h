#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

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
  double closing_speed = 0.3;  // share of the joints' greatest, in (0, 1]
  /// Fingers first go to where they are predicted to be this much [rad] before they touch, >= 0,
  /// and close from there together: one that touches long before the others would push the object.
  double gather = 0.1;
  /// Beyond the predicted touch fingers go on [rad], >= 0: predicted shapes are too large or small.
  double overrun = 0.5;
  /// N, >= 0, that the pads which touch are to feel, their mean: of a hand whose plan says no
  /// force. 0: as the motors press.
  double grip_force = 0;
  double touch_force = 0.3;  // N, > 0, of a pad's sum that touches
  double force_timeout = 4;  // s, > 0, to reach the force; then it is gripped with what there is
  double settle_time = 0.3;  // s, >= 0, after closing

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
