#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/belief/percepts.h"

namespace prehend::belief {

/// What is compared of percepts: a number of one sense, of a pad, a motor or the wrist. In the same
/// order for percepts of the same hand.
struct PerceptFeature {
  std::string sense;            // one of percept_senses()
  std::string part;             // pad, motor, "wrist" or "camera"
  std::string kind;             // which scale it has, see percept_kinds()
  std::optional<double> value;  // none: no sensor; or, of a pad that touches nothing, nowhere
  bool touches = false;         // a yes (1) or no (0), not a number
};

/// "tactile": of each pad, closed and lifted, whether it touches, the logarithm of its force, where
/// (two axes of its frame) and how much of it. "contact": when a pad first touched, as the hand's
/// closure. "joints": where motors stood, closed and lifted. "time": when they stopped. "wrist":
/// forces and torques, closing, closed and lifted. "weight": its logarithm. "view": whether a
/// camera shows what was lifted, where, how much of it and how wide.
const std::vector<std::string>& percept_senses();

/// A kind of feature and its standard scale before anything was fitted, in its unit.
struct PerceptKind {
  std::string name;
  double scale = 0;  // m, rad, N, N m, s; 1 of logarithms
  double least = 0;  // of what is fitted: below it simulation and sensors differ by more
};
const std::vector<PerceptKind>& percept_kinds();

/// @param touch_force N, of a pad that touches.
std::vector<PerceptFeature> percept_features(const Percepts& percepts, double touch_force);

}  // namespace prehend::belief
