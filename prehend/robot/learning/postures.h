#pragma once

#include <vector>

#include "prehend/robot/learning/opposition.h"

namespace prehend::robot::learning {

struct FoundPreshape {
  Preshape preshape;
  double opening = 0;  // m, between the pads
  double sure = 0;     // in [0, 1]
};

/// Preshapes by what opposes what. For each opposition:
/// - from where the pads meet, fingers open with pads that stay opposite and turn as little as they
///   can, to at most 130 mm: a pinch (two fingers), a tripod (three) or a whole-hand precision
///   grasp; where that opens by more than 75 mm, one of 55 mm, too, which passes between
///   neighbours;
/// - for fingers with two closing motors and more, a power grasp: they open by the first of them,
///   the others slightly bent, and all close at once; its tool is nearer to the palm.
/// The tool's z is the direction from the palm to where pads meet, made perpendicular to the
/// closing direction y.
/// @param least in [0, 1]: oppositions less sure are left out, but for the best one
std::vector<FoundPreshape> find_preshapes(const HandModel& hand, const Anatomy& anatomy,
                                          const std::vector<Opposition>& oppositions, double least);

}  // namespace prehend::robot::learning
