#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "prehend/text/knob.h"

namespace prehend::control {

/// What decides whether a hand holds something. No weight is predicted: objects are of unknown
/// density.
struct HoldingOptions {
  double resolution = 0.1;  // N
  double significance = 5;
  double deciding_force = 1;  // N
  double lost_share = 0.3;
  double lost_time = 0.2;  // s
  double advance = 0.2;    // rad

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"resolution", self.resolution, "N", 0.001, 100,
               "of the wrist's sensor: a change of less, or within its noise, does not show that "
               "something is held"});
    visit(Knob{"significance", self.significance, "", 0.1, 100,
               "standard deviations of the wrist's noise that are evidence"});
    visit(Knob{"deciding_force", self.deciding_force, "N", 0.01, 1000,
               "a wrist that cannot tell as much decides nothing"});
    visit(Knob{"lost_share", self.lost_share, "", 0.001, 0.999,
               "of the weight felt after the lift, below which it is lost"});
    visit(Knob{"lost_time", self.lost_time, "s", 0.001, 10, "that it must be below"});
    visit(Knob{"advance", self.advance, "rad", 0.001, 3.2,
               "that fingers which hold something do not close further"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Mean and noise of a force [N].
class ForceAverage {
 public:
  void add(const Eigen::Vector3d& force);
  void clear() { *this = {}; }
  int count() const { return count_; }
  const Eigen::Vector3d& mean() const { return mean_; }
  /// Standard deviation of one component of one sample; 0 for less than two.
  double deviation() const;

 private:
  int count_ = 0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  double squares_ = 0;
};

/// Whether a hand holds something, from what it feels alone: the change of the wrist's force since
/// the hand was free, against that sensor's noise; and the fingers, which go on closing when what
/// they press on is gone. A sensor that is too noisy, or missing, leaves it to the fingers; fingers
/// that are not known leave it to the force; without either nothing counts as held.
///
/// Forces are of contact on the hand with what it holds, the hand's own weight taken out, in any
/// frame that moves with the hand [N]. Closures as robot::ClosingWay::closure() [rad]. Unset: not
/// known. Not thread-safe.
class Holding {
 public:
  /// @throws std::invalid_argument for options out of range.
  explicit Holding(const HoldingOptions& options = {});

  /// A new attempt: all is forgotten.
  void begin();
  /// The hand is at rest and touches nothing.
  void feel_free(const std::optional<Eigen::Vector3d>& force);
  /// The fingers press, and were sent `way_left` [rad] further than they got.
  void grip(std::optional<double> closure, double way_left);
  /// The arm is at rest: begins to weigh what the hand bears, ...
  void begin_weighing() { borne_.clear(); }
  /// ... and goes on.
  void weigh(const std::optional<Eigen::Vector3d>& force);

  struct Verdict {
    bool yes = false;
    std::string why;  // in words
  };
  /// Whether something is held, after it was lifted and weighed. Keeps its weight for lost().
  Verdict held(std::optional<double> closure);
  /// Whether the hand is empty, after it has let go and was weighed.
  Verdict empty() const;
  /// While it moves: why what was held is lost, in words; empty: it is not, as far as is known.
  /// @param time [s], not decreasing. @param by_weight the weight counts too, as nothing else bears
  /// it.
  std::string lost(double time, const std::optional<Eigen::Vector3d>& force,
                   std::optional<double> closure, bool by_weight);

  /// What held() weighed [N]; unset when the sensor could not tell.
  std::optional<double> weight() const { return weight_; }
  /// The standard deviation of that by the wrist's noise [N].
  double weight_deviation() const;
  /// How far this force is from that of the free hand [N]. @pre feel_free() was told of one
  double change(const Eigen::Vector3d& force) const { return (force - free_.mean()).norm(); }

 private:
  double noise() const;  // N, of one mean against the other, that is no evidence
  bool force_decides() const;
  double borne() const { return (borne_.mean() - free_.mean()).norm(); }
  std::string closing_problem(std::optional<double> closure) const;

  HoldingOptions options_;
  ForceAverage free_, borne_;
  std::optional<double> weight_;        // N
  std::optional<double> grip_closure_;  // rad
  double largest_advance_ = 0;          // rad
  std::optional<double> filtered_;      // N
  double last_time_ = 0;                // s
  std::optional<double> light_since_;   // s
};

}  // namespace prehend::control
