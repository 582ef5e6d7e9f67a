#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/felt_pad.h"

namespace prehend::touch {

/// The pattern that one press left on one pad, whatever the force: where its texels are, and which
/// are pressed.
struct Imprint {
  std::vector<Eigen::Vector2d> places;  // m, in the pad's plane
  std::vector<double> pressed;          // 0 to 1: from less than what foam spreads to what presses
};

/// A texel counts as pressed by its share of the pressure of those that are pressed whole (the
/// median of those above half of it): 0 up to a share of 0.2, 1 from 0.7 on. So foam that spreads
/// a quarter of a texel's load to its neighbours leaves the same imprint as one that spreads
/// nothing, and its spread need not be known.
/// Texels that cannot be read are left out. Nothing where fewer than `least_touched` texels touch.
std::optional<Imprint> imprint_of(const FeltPad& pad, const FeltTexels& felt,
                                  int least_touched = 4);

/// Where an imprint lies on a learned one: p_learned = R(turn) (p_pad - shift).
struct ImprintPlacement {
  double turn = 0;                                  // rad
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  // m, in the pad's plane
};

/// How well a press fits a learned imprint.
struct ImprintFit {
  double misfit = 0;    // nats, negative log likelihood of what the texels say
  double expected = 0;  // nats, its mean over what the learned imprint lets them say there
  double variance = 0;  // nats^2, about that mean
  ImprintPlacement placement;

  /// By how many standard deviations it fits worse than it should.
  double excess() const;
};

struct ImprintOptions {
  double cell = 1e-3;       // m, > 0, of the learned map
  double half_size = 0.04;  // m, > 0, from its middle to its sides
  double blur = 1.4e-3;     // m, > 0, standard deviation of what a texel tells of its surroundings
  /// > 0, exponent of the odds that a place presses, as the texels about it say. Places press or do
  /// not: above 1, the blurred map is taken for the shape's outline that it is a picture of.
  double contrast = 2.5;
  double doubt = 0.15;  // > 0, weight, in texels, of knowing nothing: pressed as often as not
  double farthest_shift =
      0.02;  // m, >= 0, of the middle of the learned imprint from the pad's middle
  double search_step = 1.7e-3;  // m, > 0, of the first, coarse search, and of turns at 10 mm
  int starts = 6;               // >= 1, presses that are tried as the first
  int sweeps = 2;               // >= 1, of laying the presses over one another again
};

/// What several presses of one face show together: they are laid over one another, turned and
/// shifted so that they agree best, which shows more than the texels' distance lets one press show.
/// A map of how likely each place is to press; a press fits by its negative log likelihood (nats)
/// at its best placement. No drawing of the shape is needed, no orientation, no place.
class LearnedImprint {
 public:
  /// @throws std::invalid_argument without presses, or naming the option that is out of range.
  explicit LearnedImprint(const std::vector<Imprint>& presses, const ImprintOptions& options = {});

  /// A press at its best placement. Cost: about 2 ms.
  ImprintFit fit(const Imprint& press) const;

  /// Its own presses, each on the map of the others; of one press alone, none.
  const std::vector<ImprintFit>& own_fits() const { return own_fits_; }

  int cells() const { return cells_; }  // of a side of the map
  double likelihood(int row, int column) const { return map_[row * cells_ + column]; }
  double known(int row, int column) const { return weight_[row * cells_ + column]; }  // texels

 private:
  struct Found {
    double cost;
    ImprintPlacement placement;
  };
  ImprintFit judged(const Imprint& press, const Found& found) const;
  std::size_t cell_of(const Eigen::Vector2d& p_pad, const ImprintPlacement& placement) const;
  std::vector<ImprintPlacement> lay_over(const std::vector<Imprint>& presses);
  void build(const std::vector<Imprint>& presses, const std::vector<ImprintPlacement>& placements,
             std::size_t left_out);
  /// Of one that is not below `enough`, any value that is not either.
  double cost(const Imprint& press, const ImprintPlacement& placement, double enough) const;
  Found best(const Imprint& press) const;
  Found refined(const Imprint& press, Found from) const;

  ImprintOptions options_;
  int cells_ = 0;
  std::vector<double> map_, weight_;         // row by row
  std::vector<float> if_pressed_, if_free_;  // nats
  std::vector<ImprintFit> own_fits_;
};

}  // namespace prehend::touch
