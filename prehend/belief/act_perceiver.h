#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/percepts.h"
#include "prehend/contact/pad_layout.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/robot/closing_way.h"
#include "prehend/robot/hand_model.h"

namespace prehend::belief {

/// What all sensors say at one moment of an act.
struct ActMoment {
  double time = 0;              // s
  std::vector<PadImage> pads;   // in the hand's order; without texels: no sensor
  Eigen::VectorXd motors;       // rad or m, in the hand's order; empty: not known
  std::optional<Wrench> wrist;  // none: no sensor
};

/// A pad's image from its counts: what is above `touch_counts` is touched. Counts that are not
/// finite or negative say nothing, as do texels where the pad has no cell.
/// @pre counts has an entry for each texel of the layout.
PadImage pad_image(const contact::PadLayout& layout, const std::vector<double>& counts,
                   double newton_per_count, int touch_counts);

/// Makes percepts of an act from what sensors say while it is done, in a simulation or by a robot:
/// call closing() from when the hand begins to close, closed(), and, where it lifts, lifted().
class ActPerceiver {
 public:
  /// @param touch_force N, of a pad that touches. The hand outlives it.
  ActPerceiver(const robot::HandModel& hand, robot::ClosingWay way, double touch_force);

  void closing(const ActMoment& moment);
  void closed(const ActMoment& moment);
  /// @param X_WH of the hand, for what of the wrist's force is weight: z of W is up.
  void lifted(const ActMoment& moment, const geometry::RigidTransform& X_WH);

  bool empty() const { return times_.empty(); }
  const Percepts& percepts() const { return percepts_; }

 private:
  void note(std::size_t instant, const ActMoment& moment);
  void note_stop(std::size_t motor);

  const robot::HandModel& hand_;
  robot::ClosingWay way_;
  double touch_force_;  // N
  Percepts percepts_;
  Wrench sum_;  // of `wrenches_`, while it closes
  int wrenches_ = 0;
  std::vector<double> times_;            // s, since the first
  std::vector<Eigen::VectorXd> motors_;  // at those
  double start_ = 0;                     // s
  std::optional<double> touched_;        // s, since the first, when a pad first touched
};

}  // namespace prehend::belief
