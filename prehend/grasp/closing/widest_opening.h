#pragma once

#include "prehend/robot/hand_model.h"

namespace prehend::grasp {

/// How wide a hand opens [m], in the preshape in which it opens widest: between its pads, or
/// between the fingers that face each other (hand_reach()). 0 where none do.
double widest_opening(const robot::HandModel& hand);

}  // namespace prehend::grasp
