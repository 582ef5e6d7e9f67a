#include "prehend/shape/plane_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include <opencv2/imgproc.hpp>

namespace prehend::shape {
namespace {

using std::numbers::pi;
constexpr double kPriorEvidence = 0.02;      // k of the support, as a fraction of the points
constexpr double kSameAngle = 5 * pi / 180;  // rad: closer planes are one
constexpr double kSameShift = 0.03;          // of the extent
constexpr int kRefinedPerPlane = 2;          // local minima refined for each plane asked for

VoteOptions vote_options(const CompletionOptions& options, double reference) {
  return {options.depth_tolerance, std::max(2 * options.depth_tolerance, reference)};
}

std::vector<Eigen::Vector3d> in_camera(const std::vector<Eigen::Vector3d>& points_T,
                                       const geometry::RigidTransform& X_CT) {
  std::vector<Eigen::Vector3d> points_C;
  points_C.reserve(points_T.size());
  for (const Eigen::Vector3d& p_T : points_T) points_C.push_back(X_CT * p_T);
  return points_C;
}

std::vector<Eigen::Vector2d> convex_outline(const std::vector<Eigen::Vector3d>& points_T,
                                            const VotingPoints& voting) {
  std::vector<cv::Point2f> flat;
  flat.reserve(points_T.size());
  for (const Eigen::Vector3d& p : points_T) {
    const Eigen::Vector2d r = (p.head<2>() - voting.center_T.head<2>()) / voting.extent;
    flat.emplace_back(static_cast<float>(r.x()), static_cast<float>(r.y()));
  }
  std::vector<int> hull;
  cv::convexHull(flat, hull);
  std::vector<Eigen::Vector2d> outline;
  for (const int i : hull) outline.push_back(points_T[i].head<2>());
  return outline;
}

/// Turned to the half circle away from the viewer.
double normalized_turn(double turn) { return std::remainder(turn, pi); }

bool same_plane(const Candidate& a, const Candidate& b, double extent) {
  const double turned = std::remainder(a.plane.angle - b.plane.angle, pi);
  const bool opposite = std::cos(a.plane.angle - b.plane.angle) < 0;
  const double shifted = a.plane.shift - (opposite ? -b.plane.shift : b.plane.shift);
  return std::abs(turned) < kSameAngle && std::abs(shifted) < kSameShift * extent;
}

/// First and last shift of a plane with this normal [m]; see CompletionOptions::min_shift.
std::pair<double, double> plausible_shifts(const VotingPoints& voting, const Candidate& candidate,
                                           const CompletionOptions& options) {
  const double facing = std::max(0.0, std::cos(candidate.turn));
  const double low = facing * options.min_shift - (1 - facing) * options.max_shift / 3;
  const double high = (1 + 2 * facing) / 3 * options.max_shift;
  return {low * voting.extent, high * voting.extent};
}

/// The same for equation (2) of reference_vote.h.
std::pair<double, double> published_shifts(const VotingPoints& voting, const Candidate& candidate,
                                           const CompletionOptions& options) {
  double farthest = 0;
  for (const Eigen::Vector3d& p : voting.points_T) {
    farthest = std::max(farthest, candidate.plane.normal_T().dot(p - voting.center_T));
  }
  return {0, farthest * (options.shifts - 1) / (2.0 * options.shifts)};
}

}  // namespace

bool better(const Candidate& a, const Candidate& b) {
  return std::tuple(a.hypothesis.vote, std::abs(a.turn), a.plane.shift, a.turn) <
         std::tuple(b.hypothesis.vote, std::abs(b.turn), b.plane.shift, b.turn);
}

Ballot::Ballot(const VotingPoints& voting, const std::vector<Eigen::Vector3d>& points_T,
               SeenMap map, const ObjectView& view, const CompletionOptions& options)
    : voting_(voting),
      options_(options),
      X_CT_(view.X_WC.inverse() * voting.X_WT),
      fast_(in_camera(points_T, X_CT_), view.camera, std::move(map),
            vote_options(options, options.reference_fraction * voting.extent)),
      outline_(convex_outline(points_T, voting)),
      reference_(options.reference_fraction * voting.extent) {}

geometry::Plane Ballot::plane_C(const SearchedPlane& plane) const {
  const Eigen::Vector3d n_T = plane.normal_T();
  const Eigen::Vector3d n_C = X_CT_.linear() * n_T;
  return {n_C, n_C.dot(X_CT_ * Eigen::Vector3d(voting_.center_T + plane.shift * n_T))};
}

std::pair<double, double> Ballot::range(const Eigen::Vector2d& n) const {
  double least = n.dot(outline_.front()), most = least;
  for (const Eigen::Vector2d& p : outline_) {
    least = std::min(least, n.dot(p));
    most = std::max(most, n.dot(p));
  }
  return {least, most};
}

double Ballot::contradiction(const SymmetryHypothesis& h) const {
  return options_.outside_weight * h.outside + options_.in_front_weight * h.in_front;
}

double Ballot::support(const SymmetryHypothesis& h) const {
  return (h.coincident + kPriorEvidence / 2) / (h.coincident + h.contradicted + kPriorEvidence);
}

double Ballot::priors(const Candidate& candidate) const {
  const Eigen::Vector2d n = candidate.plane.normal_T().head<2>().normalized();
  const auto [near, far] = range(n);
  const auto [left, right] = range({-n.y(), n.x()});
  const double offset = n.dot(voting_.center_T.head<2>()) + candidate.plane.shift;
  const double depth = 2 * std::max(offset - near, far - offset);
  const double width = std::max(right - left, 1e-9 * voting_.extent);
  return options_.oblique_weight * (1 - std::abs(std::cos(candidate.turn))) +
         options_.depth_prior_weight * std::abs(depth / width - 1);
}

void Ballot::vote(std::vector<Candidate>& candidates) const {
  std::vector<geometry::Plane> planes_C;
  planes_C.reserve(candidates.size());
  for (const Candidate& candidate : candidates) planes_C.push_back(plane_C(candidate.plane));
  const std::vector<VoteTally> tallies = fast_.tallies(planes_C);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const VoteTally& tally = tallies[i];
    const double count = static_cast<double>(tally.points);
    SymmetryHypothesis& h = candidates[i].hypothesis;
    h.outside = tally.outside_squared / (count * reference_ * reference_);
    h.in_front = tally.in_front / (count * reference_);
    h.contradicted = tally.contradicted / count;
    h.coincident = tally.coincident / count;
    h.unseen = tally.unseen / count;
    h.vote =
        options_.vote == VoteKind::kPublished
            ? tally.published_vote()
            : contradiction(h) + options_.support_weight * (1 - support(h)) + priors(candidates[i]);
    const Eigen::Vector3d n_T = candidates[i].plane.normal_T();
    Eigen::Vector3d on_plane_T = voting_.center_T + candidates[i].plane.shift * n_T;
    if (candidates[i].plane.tilt == 0) on_plane_T.z() = 0;
    h.point_W = voting_.X_WT * on_plane_T;
    h.normal_W = voting_.X_WT.linear() * n_T;
  }
}

std::vector<Candidate> grid(const VotingPoints& voting, const CompletionOptions& options) {
  const double away = std::atan2(voting.away_T.y(), voting.away_T.x());
  const double half = (options.orientations - 1) / 2;
  const double step = half > 0 ? options.max_angle / half : options.max_angle;
  std::vector<double> turns;
  const auto starts = starting_normals(voting, options.published_start);
  const auto turn_of = [&](const Eigen::Vector2d& n) {
    return normalized_turn(std::atan2(n.y(), n.x()) - away);
  };
  const double center = options.published_start ? turn_of(starts.front()) : 0;
  for (int i = 0; i < options.orientations; ++i) turns.push_back(center + (i - half) * step);
  if (!options.published_start) {
    for (const Eigen::Vector2d& n : starts) turns.push_back(turn_of(n));
  }
  std::vector<Candidate> candidates;
  candidates.reserve(turns.size() * options.shifts);
  for (const double turn : turns) {
    Candidate candidate;
    candidate.turn = turn;
    candidate.plane.angle = away + turn;
    const auto [low, high] = options.published_start ? published_shifts(voting, candidate, options)
                                                     : plausible_shifts(voting, candidate, options);
    for (int j = 0; j < options.shifts; ++j) {
      candidate.plane.shift = low + (high - low) * j / (options.shifts - 1);
      candidates.push_back(candidate);
    }
  }
  return candidates;
}

Candidate refined(const Ballot& ballot, Candidate best, double angle_step, double shift_step,
                  double tilt_step) {
  const double least = 1e-3 * ballot.voting().extent;
  while (shift_step > least) {
    std::vector<Candidate> around;
    const auto add = [&](double angle, double shift, double tilt) {
      Candidate next = best;
      next.plane.angle += angle;
      next.turn += angle;
      next.plane.shift += shift;
      next.plane.tilt += tilt;
      around.push_back(next);
    };
    for (const int sign : {1, -1}) {
      add(0, sign * shift_step, 0);
      if (angle_step > 0) add(sign * angle_step, 0, 0);
      if (tilt_step > 0) add(0, 0, sign * tilt_step);
    }
    ballot.vote(around);
    const Candidate& next =
        *std::min_element(around.begin(), around.end(), [](const Candidate& a, const Candidate& b) {
          return a.hypothesis.vote < b.hypothesis.vote;
        });
    if (next.hypothesis.vote < best.hypothesis.vote) {
      best = next;
    } else {
      angle_step /= 2;
      shift_step /= 2;
      tilt_step /= 2;
    }
  }
  return best;
}

Candidate centered(const Ballot& ballot, const Candidate& best) {
  constexpr double kAsGood = 0.02;  // vote
  constexpr int kReach = 25;        // steps
  const double step = 0.002 * ballot.voting().extent;
  std::vector<Candidate> line(2 * kReach + 1, best);
  for (int i = -kReach; i <= kReach; ++i) line[i + kReach].plane.shift += i * step;
  ballot.vote(line);
  int ends[2] = {0, 0};
  for (const int sign : {-1, 1}) {
    for (int i = 1; i <= kReach; ++i) {
      if (line[kReach + sign * i].hypothesis.vote > best.hypothesis.vote + kAsGood) break;
      ends[sign > 0] = sign * i;
    }
  }
  std::vector<Candidate> middle{best};
  middle.front().plane.shift += 0.5 * (ends[0] + ends[1]) * step;
  ballot.vote(middle);
  return middle.front();
}

namespace {

/// The grid's local minima in angle and shift, best first.
std::vector<Candidate> local_minima(const std::vector<Candidate>& candidates, int shifts,
                                    int orientations) {
  std::vector<Candidate> minima;
  const int rows = static_cast<int>(candidates.size()) / shifts;
  const auto vote = [&](int row, int column) {
    return candidates[static_cast<std::size_t>(row) * shifts + column].hypothesis.vote;
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < shifts; ++column) {
      const double here = vote(row, column);
      bool least = true;
      // Rows beyond the regular ones are axes of the footprint, without neighbours.
      const int reach = row < orientations ? 1 : 0;
      for (int r = row - reach; r <= row + reach && least; ++r) {
        for (int c = column - 1; c <= column + 1 && least; ++c) {
          if (r < 0 || r >= (reach ? orientations : rows) || c < 0 || c >= shifts) continue;
          least = here <= vote(r, c);
        }
      }
      if (least) minima.push_back(candidates[static_cast<std::size_t>(row) * shifts + column]);
    }
  }
  std::stable_sort(minima.begin(), minima.end(), better);
  return minima;
}

std::vector<Candidate> distinct(std::vector<Candidate> candidates, double extent,
                                std::size_t most) {
  std::stable_sort(candidates.begin(), candidates.end(), better);
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    if (kept.size() == most) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return same_plane(candidate, other, extent);
    });
    if (!known) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace

SearchResult search_planes(const Ballot& coarse, const Ballot& fine,
                           const CompletionOptions& options) {
  const double extent = fine.voting().extent;
  std::vector<Candidate> candidates = grid(fine.voting(), options);
  coarse.vote(candidates);
  const std::size_t most = static_cast<std::size_t>(options.planes);
  std::vector<Candidate> minima =
      distinct(local_minima(candidates, options.shifts, options.orientations), extent,
               4 * kRefinedPerPlane * most);
  fine.vote(minima);
  std::stable_sort(minima.begin(), minima.end(), better);
  minima.resize(std::min(minima.size(), kRefinedPerPlane * most));
  if (options.refine) {
    const double angle_step = options.max_angle / options.orientations;
    const double shift_step =
        0.5 * extent * (options.max_shift - options.min_shift) / (options.shifts - 1);
    for (Candidate& candidate : minima) {
      candidate = refined(fine, candidate, angle_step, shift_step, 0);
      if (options.max_tilt > 0) {
        const Candidate tilted =
            refined(fine, candidate, angle_step, shift_step, 0.25 * options.max_tilt);
        if (std::abs(tilted.plane.tilt) <= options.max_tilt &&
            tilted.hypothesis.vote < candidate.hypothesis.vote - options.tilt_gain) {
          candidate = tilted;
        }
      }
    }
  }
  SearchResult result;
  result.planes = distinct(std::move(minima), extent, most);
  std::stable_sort(candidates.begin(), candidates.end(), better);
  for (const Candidate& candidate : candidates) result.tried.push_back(candidate.hypothesis);
  return result;
}

}  // namespace prehend::shape
