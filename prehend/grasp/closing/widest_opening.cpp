#include "prehend/grasp/closing/widest_opening.h"

#include <algorithm>

#include "prehend/grasp/closing/finger_closing.h"

namespace prehend::grasp {

double widest_opening(const robot::HandModel& hand) {
  if (hand.gripper) return hand.gripper->max_opening;
  const HandToClose to_close(hand);
  double widest = 0;
  for (const robot::Preshape& preshape : hand.preshapes) {
    widest = std::max(widest, hand_reach(to_close, preshape).max_opening);
  }
  return widest;
}

}  // namespace prehend::grasp
