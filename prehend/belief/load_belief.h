#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/grasp/load_bounds.h"

// What an object weighs and how it rubs on a hand's pads, by what attempts told.
namespace prehend::belief {

/// What one hold of an object told of its load.
///
/// A share is the force across the pads over the sum of those on them, sum |Ft| / sum Fn: what
/// friction has to give. While nothing slips, the coefficient is not below it, where it slips not
/// above (Coulomb).
struct LoadEvidence {
  std::optional<double> weight;         // N, at rest after the lift
  double weight_deviation = 0;          // N, standard, >= 0, of it
  std::optional<double> held_share;     // of pads that bore all of it at rest
  std::optional<double> slipped_share;  // the least at which it slipped
  std::optional<double> borne;          // N, the most that the hand bore when it slipped

  bool is_empty() const { return !weight && !held_share && !slipped_share && !borne; }
};

struct LoadBeliefOptions {
  double weight_resolution = 0.1;  // N, >= 0, of the wrist's sensor
  double significance = 3;         // > 0, of the weight's deviations that bound the mass
  double pad_gain = 0.25;          // >= 0, by how much sums of pads may be wrong, relative
  double acceleration = 2;         // m/s^2, >= 0, of what slips while the arm moves it

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// The bounds of one object's load: the intersection of what each hold says,
///
///     mass      within weight / g +- (significance deviations + resolution) / g,
///               and not below borne / (g + acceleration) (1 - pad_gain),
///     friction  not below held_share / (1 + pad_gain), not above slipped_share (1 + pad_gain).
///
/// The order of the evidence does not matter. Where it contradicts itself (what was weighed has
/// been emptied, a slip was none), nothing is known: `contradiction` says so, and it is to be begun
/// again without all of it.
struct LoadBelief {
  grasp::LoadBounds bounds;
  std::string contradiction;  // in words; empty: none
};
/// @throws std::invalid_argument for options out of range, and evidence that is not finite or
/// negative.
LoadBelief load_belief(const std::vector<LoadEvidence>& evidence,
                       const LoadBeliefOptions& options = {});

/// "0.28 to 0.31 kg, friction at most 0.42"; "" when nothing is known.
std::string in_words(const grasp::LoadBounds& bounds);

}  // namespace prehend::belief
