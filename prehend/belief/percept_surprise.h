#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "prehend/belief/percept_features.h"
#include "prehend/belief/percepts.h"

namespace prehend::belief {

/// How percepts scatter about what is predicted, and how much surprise is too much.
struct SurpriseModel {
  /// By percept_kinds(): of Student's t with four degrees of freedom, > 0.
  std::map<std::string, double> scales;
  /// By percept_senses(): the logarithm of its likelihood is taken times this, in (0, 1], as its
  /// features do not err independently.
  std::map<std::string, double> shares;
  /// Bits above which all together ("total") are an alarm, and a sense by itself stands out; see
  /// PerceptSurprise::alarm.
  std::map<std::string, double> thresholds;
  double wrong_touch = 0.02;  // probability that a pad touches against the prediction, in (0, 0.5)
  double touch_force = 0.3;   // N, > 0, of a pad that touches
  /// Of percept_senses(): by which an act is an alarm by itself, too, as it is known in full of an
  /// act that ends before the lift, when the total lacks half of its senses.
  std::string by_itself = "time";
  /// Whose percepts it was fitted to, HandModel::name; of others its thresholds say nothing. Empty:
  /// not fitted to any.
  std::string hand;

  /// Scales, shares and thresholds that no truth was asked for; alarms at 30 bits.
  static SurpriseModel unfitted();
  /// @throws geometry::InputError "file:line: ..." for an unknown or missing key, or values out of
  /// range.
  static SurpriseModel load(const std::filesystem::path& file);
  /// The model for a hand (HandModel::name): `path` itself where it is a file; of a folder the one
  /// that was fitted to it, HAND.yaml, else the SDH-2's (sdh2.yaml), whose scales are the best
  /// guess there is; its `hand` tells which it is. @throws geometry::InputError as load().
  static SurpriseModel load_for(const std::filesystem::path& path, const std::string& hand);
  /// @param made_by lines for the file's head.
  void save(const std::filesystem::path& file, const std::string& made_by) const;
  void validate() const;  ///< @throws std::invalid_argument naming the key.
};

/// Bits of one sense or of one part of it.
struct SenseSurprise {
  std::string sense;
  std::string part;  // pad, motor or "wrist"; empty: all of the sense
  double bits = 0;
  double threshold = 0;  // of a whole sense
  bool alarm = false;    // of a whole sense: bits > threshold; it stands out
};

/// What was perceived against what was to be.
struct PerceptSurprise {
  double bits = 0;  // of all senses together
  double threshold = 0;
  /// bits > threshold, or those of the sense SurpriseModel::by_itself are above its own.
  bool alarm = false;
  std::vector<SenseSurprise> senses;  // those there are sensors for, in percept_senses()' order
  std::vector<SenseSurprise> parts;   // of these, in the hand's order
  std::size_t likeliest = 0;          // of PerceptForecast::possible, by what was perceived
  std::string to_string() const;      // "31.2 bits (tactile 20.1!, joints 3.0)"; ! stands out
  /// Of a hand that the model was not fitted to: no alarms, all thresholds 0.
  void forget_thresholds();
};

/// The surprise of percepts y is
///     -log2 Σ_k w_k Π_i (p(y_i | k) / max p)^share  -  its expectation,
/// over the possible percepts k with their weights and all features i for which there are a
/// predicted and a perceived value; p of a number is Student's t (ν = 4) about k's with the kind's
/// scale, of a touch that was or was not to be `wrong_touch` against the rest. The expectation is
/// that when one of the possible percepts comes true, with noise:
///     Σ_j w_j [-log2 Σ_k w_k L_k(y_j)]  +  1.011 bits for each number, times the share
/// (1.011 = (ν + 1) / 2 log2(e) (ψ((ν + 1) / 2) - ψ(ν / 2)); exact for one possible percept). So 0
/// bits is as expected, less is better than expected, and 10 bits are 2^10 times less likely. Of a
/// sense or part alone: the same with its features. Bits of senses do not add up to the total, as
/// all share the possible percepts. A feature without sensor counts nowhere, nor does where a pad
/// is touched that was to touch nothing: that it touches counts.
///
/// Same arguments, same bits. @throws std::invalid_argument for percepts that are not finite (by
/// name), of another hand than the predicted ones, or without any prediction.
PerceptSurprise percept_surprise(const PerceptForecast& predicted, const Percepts& perceived,
                                 const SurpriseModel& model);

/// A right prediction and what came, or another one.
struct KnownPercepts {
  const PerceptForecast* predicted = nullptr;
  const Percepts* perceived = nullptr;
};

/// The model by which right predictions are as surprising as they are to be: scales by the median
/// of what is off against the likeliest possible percept, shares by how much the bits of each sense
/// scatter, thresholds so that of these predictions the share `false_alarms` at most is an alarm,
/// and stands out by each other sense, each -log2(false_alarms) bits at least. @param right
/// predictions that came true, 20 at least. @param by_itself see SurpriseModel.
/// @throws std::invalid_argument for fewer, `false_alarms` outside (0, 0.5), or no sense.
SurpriseModel fit_surprise(const std::vector<KnownPercepts>& right, double false_alarms = 0.01,
                           const std::string& by_itself = "time");

}  // namespace prehend::belief
