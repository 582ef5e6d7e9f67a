#include "prehend/shape/second_plane.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace prehend::shape {

using std::numbers::pi;

std::optional<SymmetryHypothesis> second_plane(const Ballot& ballot, const Candidate& first,
                                               const ObjectView& view, const SeenMap& map,
                                               const CompletionOptions& options) {
  constexpr double kEnoughCoincident = 0.1;
  constexpr double kLeastCoincident = 0.04;  // when next to nothing speaks against it
  constexpr double kMoreThanContradicted = 3;
  constexpr double kAlongSight = 0.5;  // cosine between the first plane's normal and the sight
  const VotingPoints& voting = ballot.voting();
  const geometry::RigidTransform X_CT = view.X_WC.inverse() * voting.X_WT;
  const geometry::Plane plane_C = ballot.plane_C(first.plane);
  const Eigen::Vector3d normal_T = first.plane.normal_T();
  std::vector<Eigen::Vector3d> completed;
  for (const Eigen::Vector3d& p_T : voting.points_T) {
    completed.push_back(p_T);
    const Eigen::Vector3d q_T = p_T - 2 * plane_C.signed_distance(X_CT * p_T) * normal_T;
    if (!options.drop_contradicted ||
        evidence_about(map, view.camera, X_CT * q_T, options.depth_tolerance).contradicted < 0.5) {
      completed.push_back(q_T);
    }
  }
  CompletionOptions supported = options;
  supported.vote = VoteKind::kSupported;
  supported.oblique_weight = 0;
  supported.depth_prior_weight = 0;
  const Ballot both(voting, completed, map, view, supported);

  Candidate candidate;
  candidate.plane.angle = first.plane.angle + pi / 2;
  const Eigen::Vector2d n = candidate.plane.normal_T().head<2>();
  const auto [left, right] = both.range(n);
  const double step = (right - left) / (2 * options.shifts);
  const double middle = (left + right) / 2 - n.dot(voting.center_T.head<2>());
  std::vector<Candidate> line;
  for (int i = -options.shifts / 2; i <= options.shifts / 2; ++i) {
    candidate.plane.shift = middle + i * step;
    line.push_back(candidate);
  }
  both.vote(line);
  const Candidate best = *std::min_element(line.begin(), line.end(), better);
  // Two symmetries of one solid are perpendicular, so only the shift is refined.
  const Candidate chosen = centered(both, refined(both, best, 0, step / 2, 0));
  const bool far_side_is_open = std::abs(std::cos(first.turn)) < kAlongSight;
  const SymmetryHypothesis& h = chosen.hypothesis;
  const bool is_supported =
      h.coincident >= kEnoughCoincident ||
      (h.coincident >= kLeastCoincident && h.coincident >= kMoreThanContradicted * h.contradicted);
  const bool stands_out = both.contradiction(h) <= options.max_second_vote && is_supported;
  const bool serves = far_side_is_open && h.contradicted <= options.max_contradicted / 2;
  if (!stands_out && !serves) return std::nullopt;
  return h;
}

}  // namespace prehend::shape
