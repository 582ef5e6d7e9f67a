#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/learning/anatomy.h"

namespace prehend::robot::learning {

/// Two groups of fingers that meet pad against pad.
struct Opposition {
  std::vector<int> first, second;  // fingers of the anatomy
  Eigen::VectorXd motors;          // where they meet, of all motors; other fingers stand open
  Eigen::Vector3d p_H = Eigen::Vector3d::Zero();         // m, where they meet
  Eigen::Vector3d closing_H = Eigen::Vector3d::UnitY();  // unit, from the first to the second
  double beside = 0;                                     // m, by which they miss each other
  double gap = 0;    // m, that stays between them; < 0: they pass
  double angle = 0;  // rad, by which they do not face each other

  /// In [0, 1]: 1 for pads that meet flat.
  double sure() const;
};

/// Pads of fingers with motors at `motors`, and where fingers begin, in the hand's root frame.
struct PlacedPads {
  /// Of a finger that presses ahead, normal_H is where its pad moves as it closes.
  std::vector<Eigen::Vector3d> p_H, normal_H, base_H;
};
PlacedPads placed_pads(const HandModel& hand, const Anatomy& anatomy,
                       const Eigen::VectorXd& motors);

/// Motors that move any of these fingers, sorted; of all, or of those that close only.
std::vector<int> motors_of(const Anatomy& anatomy, const std::vector<int>& fingers,
                           bool only_closing);

/// Moves the motors `free` from where they are to where `cost` is least, each within its limits, by
/// pattern search (R. Hooke, T. A. Jeeves, "Direct search solution of numerical and statistical
/// problems", 1961), steps from `first_step` of a motor's range down to a thousandth of it.
template <class Cost>
double search(const HandModel& hand, const std::vector<int>& free, double first_step,
              const Cost& cost, Eigen::VectorXd* motors) {
  double best = cost(*motors);
  for (double step = first_step; step > 1e-3; step /= 2) {
    for (int pass = 0; pass < 8; ++pass) {
      bool better = false;
      for (const int motor : free) {
        const Joint& joint =
            hand.model
                .joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(motor)])];
        for (const double sign : {1.0, -1.0}) {
          const double before = (*motors)[motor];
          (*motors)[motor] = std::clamp(before + sign * step * (joint.upper - joint.lower),
                                        joint.lower, joint.upper);
          const double there = (*motors)[motor] == before ? best : cost(*motors);
          if (there < best) {
            best = there;
            better = true;
            break;
          }
          (*motors)[motor] = before;
        }
      }
      if (!better) break;
    }
  }
  return best;
}

/// Where the pads of `first` meet those of `second`, as near and as flat as they can, far from the
/// palm rather than near; from `starts` random postures (a fixed seed).
Opposition oppose(const HandModel& hand, const Anatomy& anatomy, std::vector<int> first,
                  std::vector<int> second, int starts);

/// All that are of use: each pair of two or three fingers; of more, the two best pairs with the
/// finger that opposes the others best, the thumb, and that one against two, three, ... of them.
/// Best first; those that miss by more than 15 mm or face each other by less than 117 degrees are
/// left out.
std::vector<Opposition> find_oppositions(const HandModel& hand, const Anatomy& anatomy);

}  // namespace prehend::robot::learning
