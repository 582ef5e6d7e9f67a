#include "prehend/shape/symmetry.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>

#include "prehend/geometry/errors.h"
#include "prehend/shape/view_evidence.h"
#include "prehend/shape/voting_points.h"

namespace prehend::shape {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kPriorEvidence = 0.02;  // k of the support, as a fraction of the points

void check(const CompletionOptions& options) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("CompletionOptions." + what);
  };
  require(options.orientations >= 1 && options.orientations % 2 == 1,
          "orientations must be odd and >= 1");
  require(options.max_angle > 0 && options.max_angle <= kPi / 4, "max_angle must be in (0, pi/4]");
  require(options.shifts >= 2, "shifts must be >= 2");
  require(std::isfinite(options.min_shift) && options.min_shift < options.max_shift &&
              std::isfinite(options.max_shift),
          "min_shift must be less than max_shift");
  require(options.thinning > 0 && options.thinning <= 0.2, "thinning must be in (0, 0.2]");
  require(options.reference_fraction > 0 && std::isfinite(options.reference_fraction),
          "reference_fraction must be > 0");
  require(options.depth_tolerance > 0 && std::isfinite(options.depth_tolerance),
          "depth_tolerance must be > 0");
  for (const auto& [value, name] : {std::pair{options.outside_weight, "outside_weight"},
                                    {options.in_front_weight, "in_front_weight"},
                                    {options.support_weight, "support_weight"},
                                    {options.oblique_weight, "oblique_weight"},
                                    {options.depth_prior_weight, "depth_prior_weight"},
                                    {options.max_second_vote, "max_second_vote"}}) {
    require(value >= 0 && std::isfinite(value), std::string(name) + " must be >= 0");
  }
}

/// A vertical plane {p : n(angle) · p = offset} in the frame T.
struct VerticalPlane {
  double angle = 0;   // rad, of the normal from T's x axis
  double offset = 0;  // m

  Eigen::Vector2d normal() const { return {std::cos(angle), std::sin(angle)}; }
};

/// Votes for planes with one set of points.
class Ballot {
 public:
  Ballot(const VotingPoints& voting, std::vector<Eigen::Vector3d> points_T,
         const ViewEvidence& evidence, const geometry::RigidTransform& X_CT,
         const CompletionOptions& options)
      : voting_(voting),
        points_T_(std::move(points_T)),
        evidence_(evidence),
        X_CT_(X_CT),
        options_(options),
        reference_(options.reference_fraction * voting.extent) {
    points_C_.reserve(points_T_.size());
    for (const Eigen::Vector3d& p_T : points_T_) points_C_.push_back(X_CT_ * p_T);
  }

  /// Extent of the points along n [m].
  std::pair<double, double> range(const Eigen::Vector2d& n) const {
    double least = n.dot(points_T_.front().head<2>());
    double most = least;
    for (const Eigen::Vector3d& p : points_T_) {
      const double along = n.dot(p.head<2>());
      least = std::min(least, along);
      most = std::max(most, along);
    }
    return {least, most};
  }

  SymmetryHypothesis vote(const VerticalPlane& plane) const {
    const Eigen::Vector2d n = plane.normal();
    const Eigen::Vector3d n_C = X_CT_.linear() * Eigen::Vector3d(n.x(), n.y(), 0);
    const double moved = std::max(2 * options_.depth_tolerance, reference_);
    SymmetryHypothesis hypothesis;
    for (std::size_t i = 0; i < points_T_.size(); ++i) {
      const double shift = 2 * (plane.offset - n.dot(points_T_[i].head<2>()));
      const PointEvidence q = evidence_.about(points_C_[i] + shift * n_C);
      const double outside = q.outside / reference_;
      hypothesis.outside += outside * outside;
      hypothesis.in_front += q.in_front / reference_;
      hypothesis.contradicted += q.contradicted;
      if (std::abs(shift) > moved) hypothesis.coincident += q.coincident;
    }
    const double count = static_cast<double>(points_T_.size());
    hypothesis.outside /= count;
    hypothesis.in_front /= count;
    hypothesis.contradicted /= count;
    hypothesis.coincident /= count;
    hypothesis.vote = contradiction(hypothesis);
    if (options_.vote == VoteKind::kSupported) {
      hypothesis.vote += support_term(hypothesis) + prior_terms(plane);
    }
    const Eigen::Vector2d on_plane =
        voting_.center_T + (plane.offset - n.dot(voting_.center_T)) * n;
    hypothesis.point_W = voting_.X_WT * Eigen::Vector3d(on_plane.x(), on_plane.y(), 0);
    hypothesis.normal_W = voting_.X_WT.linear() * Eigen::Vector3d(n.x(), n.y(), 0);
    return hypothesis;
  }

  double contradiction(const SymmetryHypothesis& h) const {
    return options_.outside_weight * h.outside + options_.in_front_weight * h.in_front;
  }

  double support_term(const SymmetryHypothesis& h) const {
    const double support =
        (h.coincident + kPriorEvidence / 2) / (h.coincident + h.contradicted + kPriorEvidence);
    return options_.support_weight * (1 - support);
  }

 private:
  double prior_terms(const VerticalPlane& plane) const {
    const Eigen::Vector2d n = plane.normal();
    const auto [near, far] = range(n);
    const auto [left, right] = range({-n.y(), n.x()});
    const double depth = 2 * std::max(plane.offset - near, far - plane.offset);
    const double width = std::max(right - left, 1e-9 * voting_.extent);
    return options_.oblique_weight * (1 - std::abs(n.dot(voting_.away_T))) +
           options_.depth_prior_weight * std::abs(depth / width - 1);
  }

  const VotingPoints& voting_;
  std::vector<Eigen::Vector3d> points_T_;
  std::vector<Eigen::Vector3d> points_C_;
  const ViewEvidence& evidence_;
  geometry::RigidTransform X_CT_;
  const CompletionOptions& options_;
  double reference_;  // m
};

struct Candidate {
  VerticalPlane plane;
  double turn = 0;  // rad, from the starting axis
  SymmetryHypothesis hypothesis;
};

/// Fewest contradictions first; where the view decides nothing, the least turned, then the nearest.
bool better(const Candidate& a, const Candidate& b) {
  return std::tuple(a.hypothesis.vote, std::abs(a.turn), a.plane.offset, a.turn) <
         std::tuple(b.hypothesis.vote, std::abs(b.turn), b.plane.offset, b.turn);
}

/// Pattern search in angle and offset from `best`, steps halved until they do not matter.
Candidate refined(const Ballot& ballot, Candidate best, double angle_step, double offset_step,
                  double least_offset_step) {
  while (offset_step > least_offset_step) {
    Candidate next = best;
    for (const auto& [da, db] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      Candidate tried = best;
      tried.plane.angle += da * angle_step;
      tried.turn += da * angle_step;
      tried.plane.offset += db * offset_step;
      tried.hypothesis = ballot.vote(tried.plane);
      if (tried.hypothesis.vote < next.hypothesis.vote) next = tried;
    }
    if (next.hypothesis.vote < best.hypothesis.vote) {
      best = next;
    } else {
      angle_step /= 2;
      offset_step /= 2;
    }
  }
  return best;
}

/// The middle of the shifts round `best` whose vote is nearly as good. Round the true plane the
/// vote is flat within the tolerance, with shallow dents where points cross pixels.
Candidate centered(const Ballot& ballot, const Candidate& best, double extent) {
  constexpr double kAsGood = 0.02;  // vote
  constexpr int kReach = 25;        // steps
  const double step = 0.002 * extent;
  int ends[2] = {0, 0};
  for (const int sign : {-1, 1}) {
    for (int i = 1; i <= kReach; ++i) {
      const VerticalPlane plane{best.plane.angle, best.plane.offset + sign * i * step};
      if (ballot.vote(plane).vote > best.hypothesis.vote + kAsGood) break;
      ends[sign > 0] = sign * i;
    }
  }
  Candidate middle = best;
  middle.plane.offset += 0.5 * (ends[0] + ends[1]) * step;
  middle.hypothesis = ballot.vote(middle.plane);
  return middle;
}

/// All planes of the grid round one starting normal, and the refined best of them.
std::vector<Candidate> search(const Ballot& ballot, const VotingPoints& voting,
                              const Eigen::Vector2d& start, const CompletionOptions& options) {
  const double half = (options.orientations - 1) / 2;
  const double angle_step = half > 0 ? options.max_angle / half : options.max_angle;
  const double shift_step =
      voting.extent * (options.max_shift - options.min_shift) / (options.shifts - 1);
  std::vector<Candidate> candidates;
  for (int i = 0; i < options.orientations; ++i) {
    Candidate candidate;
    candidate.turn = (i - half) * angle_step;
    candidate.plane.angle = std::atan2(start.y(), start.x()) + candidate.turn;
    const double center = candidate.plane.normal().dot(voting.center_T);
    for (int j = 0; j < options.shifts; ++j) {
      candidate.plane.offset = center + options.min_shift * voting.extent + j * shift_step;
      candidate.hypothesis = ballot.vote(candidate.plane);
      candidates.push_back(candidate);
    }
  }
  if (options.refine) {
    const Candidate best = *std::min_element(candidates.begin(), candidates.end(), better);
    candidates.push_back(
        refined(ballot, best, angle_step / 2, shift_step / 2, 1e-3 * voting.extent));
  }
  return candidates;
}

Eigen::Vector3d mirrored_T(const VerticalPlane& plane, const Eigen::Vector3d& p_T) {
  const Eigen::Vector2d n = plane.normal();
  const double shift = 2 * (plane.offset - n.dot(p_T.head<2>()));
  return p_T + shift * Eigen::Vector3d(n.x(), n.y(), 0);
}

/// The plane perpendicular to `first` that the points completed at it contradict least, when that
/// is little and enough of them come to lie on what was seen.
std::optional<SymmetryHypothesis> second_plane(const VotingPoints& voting,
                                               const VerticalPlane& first,
                                               const ViewEvidence& evidence,
                                               const geometry::RigidTransform& X_CT,
                                               const CompletionOptions& options) {
  constexpr double kLeastCoincident = 0.1;
  std::vector<Eigen::Vector3d> completed;
  for (const Eigen::Vector3d& p_T : voting.points_T) {
    completed.push_back(p_T);
    const Eigen::Vector3d q_T = mirrored_T(first, p_T);
    if (!options.drop_contradicted || evidence.about(X_CT * q_T).contradicted < 0.5) {
      completed.push_back(q_T);
    }
  }
  CompletionOptions supported = options;
  supported.vote = VoteKind::kSupported;
  supported.oblique_weight = 0;
  supported.depth_prior_weight = 0;
  const Ballot ballot(voting, std::move(completed), evidence, X_CT, supported);

  Candidate candidate;
  candidate.plane.angle = first.angle + kPi / 2;
  const auto [left, right] = ballot.range(candidate.plane.normal());
  const double step = (right - left) / (2 * options.shifts);
  const double middle = (left + right) / 2;
  std::optional<Candidate> best;
  for (int i = -options.shifts / 2; i <= options.shifts / 2; ++i) {
    candidate.plane.offset = middle + i * step;
    candidate.hypothesis = ballot.vote(candidate.plane);
    if (!best || better(candidate, *best)) best = candidate;
  }
  // Two symmetries of one solid are perpendicular, so only the shift is refined.
  const Candidate chosen =
      centered(ballot, refined(ballot, *best, 0, step / 2, 1e-3 * voting.extent), voting.extent);
  if (ballot.contradiction(chosen.hypothesis) > options.max_second_vote ||
      chosen.hypothesis.coincident < kLeastCoincident) {
    return std::nullopt;
  }
  return chosen.hypothesis;
}

/// Appends the points of `source` (of `shape` so far) mirrored at `plane`.
void append_mirrored(CompletedShape& shape, std::size_t count, const SymmetryHypothesis& plane,
                     bool is_second, const ViewEvidence& evidence,
                     const geometry::RigidTransform& X_CW, bool drop_contradicted) {
  auto& cloud = shape.cloud_W;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d q_W = mirrored(plane, cloud.points[i].cast<double>());
    if (drop_contradicted && evidence.about(X_CW * q_W).contradicted >= 0.5) continue;
    cloud.points.push_back(q_W.cast<float>());
    if (!cloud.colors.empty()) cloud.colors.push_back(geometry::Rgb(cloud.colors[i]));
    const bool of_mirrored = shape.origin[i] == PointOrigin::kMirrored;
    shape.origin.push_back(!is_second    ? PointOrigin::kMirrored
                           : of_mirrored ? PointOrigin::kMirroredBoth
                                         : PointOrigin::kMirroredSecond);
  }
}

}  // namespace

CompletionOptions as_published() {
  CompletionOptions options;
  options.vote = VoteKind::kContradiction;
  options.footprint_axes = false;
  options.refine = false;
  options.second_plane = false;
  options.drop_contradicted = false;
  return options;
}

CompletedShape complete_by_symmetry(const ObjectView& view, const CompletionOptions& options) {
  check(options);
  const VotingPoints voting = make_voting_points(view, options.thinning);
  const ViewEvidence evidence(view, options.depth_tolerance);
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  const geometry::RigidTransform X_CT = X_CW * voting.X_WT;
  const Ballot ballot(voting, voting.points_T, evidence, X_CT, options);

  const double half_step = options.max_angle / options.orientations;
  std::vector<Candidate> candidates;
  for (const Eigen::Vector2d& start : starting_normals(voting, options.footprint_axes, half_step)) {
    const std::vector<Candidate> found = search(ballot, voting, start, options);
    candidates.insert(candidates.end(), found.begin(), found.end());
  }
  std::stable_sort(candidates.begin(), candidates.end(), better);
  if (options.refine) {
    candidates.insert(candidates.begin(), centered(ballot, candidates.front(), voting.extent));
  }

  CompletedShape shape;
  for (const Candidate& candidate : candidates) shape.hypotheses.push_back(candidate.hypothesis);
  shape.symmetry = shape.hypotheses.front();
  shape.viewpoint_W = view.X_WC.translation();
  shape.mirrored_viewpoint_W = mirrored(shape.symmetry, shape.viewpoint_W);
  if (options.second_plane) {
    shape.second_symmetry = second_plane(voting, candidates.front().plane, evidence, X_CT, options);
  }

  shape.cloud_W.points = view.cloud_W.points;
  shape.cloud_W.colors = view.cloud_W.colors;
  shape.origin.assign(shape.cloud_W.size(), PointOrigin::kSeen);
  append_mirrored(shape, shape.cloud_W.size(), shape.symmetry, false, evidence, X_CW,
                  options.drop_contradicted);
  if (shape.second_symmetry) {
    append_mirrored(shape, shape.cloud_W.size(), *shape.second_symmetry, true, evidence, X_CW,
                    options.drop_contradicted);
  }
  return shape;
}

}  // namespace prehend::shape
