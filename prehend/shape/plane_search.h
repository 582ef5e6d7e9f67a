#pragma once

#include <optional>
#include <vector>

#include "prehend/shape/completion_options.h"
#include "prehend/shape/fast_vote.h"
#include "prehend/shape/voting_points.h"

namespace prehend::shape {

/// A plane of symmetry in the frame T of VotingPoints, as the search turns, shifts and tilts it.
struct SearchedPlane {
  double angle = 0;  // rad, of the normal about the table's normal, from T's x
  double shift = 0;  // m, along the normal from the voting points' centre
  double tilt = 0;   // rad, of the normal from the table

  Eigen::Vector3d normal_T() const {
    return {std::cos(tilt) * std::cos(angle), std::cos(tilt) * std::sin(angle), std::sin(tilt)};
  }
};

struct Candidate {
  SearchedPlane plane;
  double turn = 0;  // rad, of the normal from the direction away from the viewer, |turn| <= pi/2
  SymmetryHypothesis hypothesis;

  /// Mirrors what was seen to where it was not: the normal is within 52 deg of the viewing
  /// direction. Other planes map the seen side onto itself; they tell of symmetry, not of the far
  /// side.
  bool facing() const { return std::cos(turn) > 0.6156615; }
};

/// Fewest contradictions first; where the view decides nothing, the least turned, then the nearest.
bool better(const Candidate& a, const Candidate& b);

/// Votes for planes with one set of points.
class Ballot {
 public:
  /// All points vote that are given; `voting` says where they are. References are kept.
  Ballot(const VotingPoints& voting, const std::vector<Eigen::Vector3d>& points_T, SeenMap map,
         const ObjectView& view, const CompletionOptions& options);

  /// Fills in the hypotheses. O(candidates x points).
  void vote(std::vector<Candidate>& candidates) const;

  /// What contradicts the view, of a hypothesis: the vote without support and priors.
  double contradiction(const SymmetryHypothesis& hypothesis) const;
  /// The published vote's and the supported one's other parts.
  double support(const SymmetryHypothesis& hypothesis) const;

  /// Extent of the voting points along the unit vector `n` of the table [m].
  std::pair<double, double> range(const Eigen::Vector2d& n) const;
  geometry::Plane plane_C(const SearchedPlane& plane) const;
  const VotingPoints& voting() const { return voting_; }

 private:
  double priors(const Candidate& candidate) const;

  const VotingPoints& voting_;
  const CompletionOptions& options_;
  geometry::RigidTransform X_CT_;
  FastVote fast_;
  std::vector<Eigen::Vector2d> outline_;  // convex, of the points along the table
  double reference_;                      // m
};

/// Every plane of the grid, orientation by orientation, without votes.
std::vector<Candidate> grid(const VotingPoints& voting, const CompletionOptions& options);

/// Compass search from `start`: turns and shifts it (and tilts it, when `tilt_step` > 0) by steps
/// that are halved when none of them helps, until the shift's is below 1e-3 of the extent.
Candidate refined(const Ballot& ballot, Candidate start, double angle_step, double shift_step,
                  double tilt_step);

/// The middle of the shifts round `best` whose vote is nearly as good. Round the true plane the
/// vote is flat within the tolerance, with shallow dents where points cross pixels.
Candidate centered(const Ballot& ballot, const Candidate& best);

struct SearchResult {
  std::vector<Candidate> planes;          // distinct, refined, best first
  std::vector<SymmetryHypothesis> tried;  // the whole grid, best first
};

/// Coarse to fine. Level 1 votes for the whole grid with a ninth of the points; the local minima's
/// best go to level 2, where all voting points refine them; of planes that came to lie together the
/// best stays.
SearchResult search_planes(const Ballot& coarse, const Ballot& fine,
                           const CompletionOptions& options);

}  // namespace prehend::shape
