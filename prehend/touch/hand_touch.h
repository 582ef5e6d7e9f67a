#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/hand_model.h"
#include "prehend/touch/felt_pad.h"

namespace prehend::touch {

/// What a pad of a hand says now.
struct PadFrame {
  std::string pad;                      // by the hand's name of it
  std::shared_ptr<const FeltPad> felt;  // never null
  std::vector<double> counts;           // of its texels
};

/// The pad of a hand's file. Its frames are those of FeltPad: `mirrored` as felt_pad()'s.
std::shared_ptr<const FeltPad> felt_pad_of(const robot::HandPad& pad, bool mirrored = false);

/// Of all joints of the hand's model, as HandModel::all_positions(), from those that are named.
/// @param joints, positions [rad or m] of the hand; a platform's prefix "hand_" may stand before a
/// name, others are left out. Joints that are not named stand as the motors have them.
/// @throws std::invalid_argument for a motor that is not named.
Eigen::VectorXd joint_positions(const robot::HandModel& hand,
                                const std::vector<std::string>& joints,
                                const std::vector<double>& positions);

/// How one pad touches what the hand holds: by its touched texels and where the pad is. In the
/// hand's root frame H, SI units.
struct PadContact {
  std::string pad;
  double force = 0;             // N, normal, sum of the texels'
  double area = 0;              // m^2, of the touched texels
  double largest_pressure = 0;  // Pa
  double full = 0;              // share of the touched texels that can say no more
  Eigen::Vector3d p_H;          // m, centre of pressure
  Eigen::Vector3d n_H;          // unit, out of the pad: mean of the texels' by force
  Eigen::Vector3d along_H;      // unit, in the pad's face, towards the fingertip (y of P)
  Eigen::Vector2d place;        // m, of the centre of pressure, x and y of P
  /// m, from there to the pad's nearest edge (of the rectangle round its texels in x and y), below
  /// 0 beyond it.
  double margin = 0;
  double margin_to_tip = 0;  // m, the same to the edge at the fingertip alone
  Eigen::Vector2d spread;    // m, standard deviations of force, across and along the finger
  double arm = 0;            // m, mean distance of force from the centre: mu F arm is the
                             // torque that friction holds (contact::holding_torque)
};

/// The pads of a hand, together.
class HandTouch {
 public:
  explicit HandTouch(robot::HandModel hand);

  const robot::HandModel& hand() const { return hand_; }
  /// Those pads that touch something with more than `least_force` [N], in the order of `frames`.
  /// @param joints, positions as joint_positions().
  /// @throws std::invalid_argument as joint_positions(), for a pad that the hand has not, a frame
  /// that has not as many counts as its pad texels.
  std::vector<PadContact> contacts(const std::vector<std::string>& joints,
                                   const std::vector<double>& positions,
                                   const std::vector<PadFrame>& frames,
                                   double least_force = 0.05) const;
  /// The same with the hand's joints as joint_positions() hands them back.
  std::vector<PadContact> contacts(const Eigen::VectorXd& joints,
                                   const std::vector<PadFrame>& frames,
                                   double least_force = 0.05) const;

 private:
  robot::HandModel hand_;
};

}  // namespace prehend::touch
