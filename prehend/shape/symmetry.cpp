#include "prehend/shape/symmetry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "prehend/shape/fallbacks.h"
#include "prehend/shape/hollows.h"
#include "prehend/shape/mask_holes.h"
#include "prehend/shape/outline.h"
#include "prehend/shape/plane_search.h"
#include "prehend/shape/second_plane.h"

namespace prehend::shape {
namespace {

/// One completion in the making.
class Completion {
 public:
  Completion(const ObjectView& view, VotingPoints voting, const CompletionOptions& options,
             const ConfidenceModel& model)
      : view_(view),
        options_(options),
        model_(model),
        X_CW_(view.X_WC.inverse()),
        voting_(std::move(voting)) {}

  CompletedShape run() {
    SeenMap map = make_seen_map(view_, window());
    const Ballot fine(voting_, voting_.points_T, map, view_, options_);
    SearchResult found =
        options_.published_start
            ? search_planes(fine, fine, options_)
            : search_planes(Ballot(voting_, voting_.coarse_points_T, map, view_, options_), fine,
                            options_);
    map_ = std::move(map);
    drop_beside_image(found.planes);
    const Candidate chosen = primary(fine, found.planes);
    CompletedShape best = completed_by(fine, chosen, found.planes);
    if (best.method == CompletionMethod::kMirror) {
      for (const Candidate& other : alternatives(fine, chosen, found.planes)) {
        best.alternatives.push_back(completed_by(fine, other, found.planes));
      }
    }
    if (options_.other_methods) add_other_methods(best, fine, chosen);
    best.hypotheses = std::move(found.tried);
    best.hypotheses.insert(best.hypotheses.begin(), best.symmetry);
    for (const Candidate& plane : found.planes) best.planes.push_back(plane.hypothesis);
    if (view_.depth && !view_.depth->empty()) best.seen_space = seen_space_round(best);
    return best;
  }

 private:
  /// What is seen whole has no other half beside the image, where nothing contradicts it.
  void drop_beside_image(std::vector<Candidate>& planes) const {
    constexpr double kMostUnseen = 0.2;
    if (reaches_border(view_.mask)) return;
    const auto is_beside = [](const Candidate& c) { return c.hypothesis.unseen > kMostUnseen; };
    if (!std::all_of(planes.begin(), planes.end(), is_beside)) std::erase_if(planes, is_beside);
  }

  /// With room for a surface that bulges between the points.
  SeenSpace seen_space_round(const CompletedShape& shape) const {
    constexpr int kMargin = 8;  // pixels
    std::vector<Eigen::Vector3f> points = shape.cloud_W.points;
    for (const auto* others : {&shape.alternatives, &shape.other_methods}) {
      for (const CompletedShape& other : *others) {
        points.insert(points.end(), other.cloud_W.points.begin(), other.cloud_W.points.end());
      }
    }
    return make_seen_space(*view_.depth, view_.camera, view_.X_WC, view_.table_W, points, kMargin);
  }

  CompletedShape completed_by(const Ballot& fine, Candidate best,
                              const std::vector<Candidate>& planes) {
    begin_shape();
    if (options_.refine) best = centered(fine, best);
    set_evidence(fine, best, planes);
    if (acceptable(fine, best, options_.max_contradicted)) {
      mirror(fine, best);
    } else {
      fall_back(fine, best);
    }
    set_confidence();
    return std::move(shape_);
  }

  /// What the fall-backs make of it, but for the one that completed it.
  void add_other_methods(CompletedShape& best, const Ballot& fine, const Candidate& chosen) {
    for (const auto& [make, name] : kFallbacks) {
      const std::optional<Fallback> fallback = make(fallback_input());
      if (!fallback || fallback->method == best.method ||
          fallback->contradicted > options_.max_contradicted) {
        continue;
      }
      begin_shape();
      set_evidence(fine, chosen, {});
      use(*fallback);
      set_confidence();
      best.other_methods.push_back(std::move(shape_));
    }
    if (best.method == CompletionMethod::kMirror) add_mirrored_down(best, fine, chosen);
  }

  /// What lies on its side is mostly as round below as above: the plane's completion mirrored at
  /// the level half way up as well.
  void add_mirrored_down(CompletedShape& best, const Ballot& fine, const Candidate& chosen) {
    double top = 0;  // m, over the table
    for (const Eigen::Vector3d& p_T : voting_.points_T) top = std::max(top, p_T.z());
    std::vector<Candidate> down(1);
    down.front().plane.tilt = std::numbers::pi / 2;
    down.front().plane.shift = 0.5 * top - voting_.center_T.z();
    fine.vote(down);
    SymmetryHypothesis level = down.front().hypothesis;
    level.vote = fine.contradiction(level) + options_.support_weight * (1 - fine.support(level));
    if (!acceptable(fine, down.front(), options_.max_contradicted)) return;
    begin_shape();
    set_evidence(fine, chosen, {});
    shape_.symmetry = best.symmetry;
    shape_.symmetry.vote = std::max(shape_.symmetry.vote, level.vote);
    shape_.mirrored_viewpoint_W = best.mirrored_viewpoint_W;
    shape_.second_symmetry = level;
    append_mirrored(shape_.symmetry, false);
    append_mirrored(level, true);
    set_confidence();
    best.other_methods.push_back(std::move(shape_));
  }

  std::vector<Candidate> alternatives(const Ballot& fine, const Candidate& chosen,
                                      const std::vector<Candidate>& planes) const {
    std::vector<Candidate> others;
    for (const Candidate& other : planes) {
      if (static_cast<int>(others.size()) == options_.alternatives) break;
      const bool other_plane = other.plane.angle != chosen.plane.angle ||
                               other.plane.shift != chosen.plane.shift ||
                               other.plane.tilt != chosen.plane.tilt;
      if (other_plane && other.facing() && acceptable(fine, other, options_.max_contradicted) &&
          other.hypothesis.vote <= chosen.hypothesis.vote + options_.alternative_vote) {
        others.push_back(other);
      }
    }
    return others;
  }

  /// Holds every mirrored point of the grid.
  PixelWindow window() const {
    const geometry::RigidTransform X_CT = X_CW_ * voting_.X_WT;
    std::vector<geometry::Plane> planes_C;
    for (const Candidate& candidate : grid(voting_, options_)) {
      const Eigen::Vector3d n_T = candidate.plane.normal_T();
      const Eigen::Vector3d n_C = X_CT.linear() * n_T;
      planes_C.push_back(
          {n_C, n_C.dot(X_CT * Eigen::Vector3d(voting_.center_T + candidate.plane.shift * n_T))});
    }
    return window_of_mirrored(view_, planes_C);
  }

  bool acceptable(const Ballot& ballot, const Candidate& candidate, double most) const {
    return candidate.hypothesis.contradicted <= most &&
           ballot.support(candidate.hypothesis) >= options_.min_support;
  }

  /// The best facing plane; when every facing one is refused or votes far worse, one that is not
  /// facing and contradicts the view much less. It predicts little, so it must be better than a
  /// fall-back at that.
  Candidate primary(const Ballot& ballot, const std::vector<Candidate>& planes) const {
    const auto facing =
        std::find_if(planes.begin(), planes.end(), [](const Candidate& c) { return c.facing(); });
    constexpr double kFarWorse = 0.5;  // vote
    const bool found = facing != planes.end();
    const bool serves = found && acceptable(ballot, *facing, options_.max_contradicted);
    // A facing plane may vote worse, by the more the more of what can be judged agrees with it.
    const double allowed =
        found ? kFarWorse * std::clamp(4 * ballot.support(facing->hypothesis) - 2, 0.0, 1.0) : 0;
    if (serves && facing->hypothesis.vote <= planes.front().hypothesis.vote + allowed) {
      return *facing;
    }
    const double most =
        std::max(options_.max_contradicted, found ? facing->hypothesis.contradicted : 0) / 3;
    const auto other = std::find_if(planes.begin(), planes.end(), [&](const Candidate& c) {
      return acceptable(ballot, c, most);
    });
    if (other != planes.end() &&
        !(serves && facing->hypothesis.vote <= other->hypothesis.vote + allowed)) {
      return *other;
    }
    return found ? *facing : planes.front();
  }

  void set_evidence(const Ballot& ballot, const Candidate& best,
                    const std::vector<Candidate>& planes) {
    Evidence& e = shape_.evidence;
    e.contradiction = ballot.contradiction(best.hypothesis);
    e.contradicted = best.hypothesis.contradicted;
    e.support = ballot.support(best.hypothesis);
    e.coincident = best.hypothesis.coincident;
    e.unseen = best.hypothesis.unseen;
    for (const Candidate& other : planes) {
      if (!other.facing() || std::abs(other.turn - best.turn) < 0.1) continue;
      e.margin = std::clamp(other.hypothesis.vote - best.hypothesis.vote, 0.0, 1.0);
      break;
    }
    const Eigen::Vector3d viewpoint_T = voting_.X_WT.inverse() * view_.X_WC.translation();
    const Hollows hollow = hollows(voting_.coarse_points_T, viewpoint_T, Eigen::Vector3d::UnitZ(),
                                   std::max(3 * options_.depth_tolerance, 0.1 * voting_.extent));
    e.concavity = std::min(1.0, hollow.depth / voting_.extent);
    e.open_top = hollow.open_top;
    e.cut_by_image = view_.is_cut || reaches_border(view_.mask);
    if (view_.nearer && !view_.nearer->data.empty()) {
      e.occluded = hidden_outline_share(view_.mask, *view_.nearer);
    }
    e.on_another = view_.on_another;
    e.may_be_several = view_.may_be_several;
    e.disagreement = disagreement(ballot, best, planes);
  }

  /// How far the prediction by the next plane is from that by `best`, see Evidence.
  double disagreement(const Ballot& ballot, const Candidate& best,
                      const std::vector<Candidate>& planes) const {
    constexpr double kOtherTurn = 0.1;     // rad
    constexpr double kOtherShift = 0.03;   // of the extent
    constexpr double kNearlyAsGood = 0.1;  // vote
    const auto other = std::find_if(planes.begin(), planes.end(), [&](const Candidate& c) {
      return c.facing() && acceptable(ballot, c, options_.max_contradicted) &&
             c.hypothesis.vote <= best.hypothesis.vote + kNearlyAsGood &&
             (std::abs(c.turn - best.turn) >= kOtherTurn ||
              std::abs(c.plane.shift - best.plane.shift) >= kOtherShift * voting_.extent);
    });
    if (other == planes.end()) return 0;
    const auto at = [&](const Candidate& candidate, const Eigen::Vector3d& p_T) {
      return Eigen::Vector3d(voting_.X_WT.inverse() *
                             mirrored(candidate.hypothesis, voting_.X_WT * p_T));
    };
    std::vector<Eigen::Vector3d> surface = voting_.points_T;
    for (const Eigen::Vector3d& p_T : voting_.points_T) surface.push_back(at(best, p_T));
    double sum = 0;
    for (const Eigen::Vector3d& p_T : voting_.coarse_points_T) {
      const Eigen::Vector3d q_T = at(*other, p_T);
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& s : surface) nearest = std::min(nearest, (s - q_T).squaredNorm());
      sum += std::sqrt(nearest);
    }
    return sum / static_cast<double>(voting_.coarse_points_T.size());
  }

  void mirror(const Ballot& ballot, const Candidate& best) {
    shape_.symmetry = best.hypothesis;
    shape_.mirrored_viewpoint_W = mirrored(shape_.symmetry, shape_.viewpoint_W);
    if (options_.second_plane) {
      shape_.second_symmetry = second_plane(ballot, best, view_, map_, options_);
    }
    append_mirrored(shape_.symmetry, false);
    if (shape_.second_symmetry) append_mirrored(*shape_.second_symmetry, true);
  }

  /// Appends all points so far mirrored at `plane`.
  void append_mirrored(const SymmetryHypothesis& plane, bool is_second) {
    auto& cloud = shape_.cloud_W;
    const std::size_t count = cloud.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d q_W = mirrored(plane, cloud.points[i].cast<double>());
      const PointOrigin origin = !is_second ? PointOrigin::kMirrored
                                 : shape_.origin[i] == PointOrigin::kMirrored
                                     ? PointOrigin::kMirroredBoth
                                     : PointOrigin::kMirroredSecond;
      if (append(q_W, origin) && !cloud.colors.empty()) {
        cloud.colors.push_back(geometry::Rgb(cloud.colors[i]));
      }
    }
  }

  /// Appends one predicted point, unless the view contradicts it.
  bool append(const Eigen::Vector3d& p_W, PointOrigin origin) {
    const PointEvidence e =
        evidence_about(map_, view_.camera, X_CW_ * p_W, options_.depth_tolerance);
    if (options_.drop_contradicted && e.contradicted >= 0.5) return false;
    shape_.cloud_W.points.push_back(p_W.cast<float>());
    shape_.origin.push_back(origin);
    shape_.support.push_back(e.unseen           ? PointSupport::kUnseen
                             : e.coincident > 0 ? PointSupport::kSupported
                                                : PointSupport::kOccluded);
    behind_.push_back(static_cast<float>(e.behind));
    return true;
  }

  /// `shape_` is what was seen.
  void begin_shape() {
    shape_ = {};
    shape_.cloud_W.points = view_.cloud_W.points;
    shape_.cloud_W.colors = view_.cloud_W.colors;
    shape_.viewpoint_W = view_.X_WC.translation();
    const std::size_t count = shape_.cloud_W.size();
    shape_.origin.assign(count, PointOrigin::kSeen);
    shape_.support.assign(count, PointSupport::kSeen);
    behind_.assign(count, 0.f);
  }

  FallbackInput fallback_input() const {
    return {voting_,
            map_,
            view_.camera,
            X_CW_ * voting_.X_WT,
            options_.depth_tolerance,
            0.015 * voting_.extent};
  }

  /// Completes without `refused`, the best plane, unless the view speaks against every other way at
  /// least as much: all are measured alike, by the share of their points where the camera looked
  /// through.
  void fall_back(const Ballot& ballot, const Candidate& refused) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "mirror: the view speaks against %.0f %% of the best plane's points, for %.0f %%",
                  100 * refused.hypothesis.contradicted, 100 * refused.hypothesis.coincident);
    shape_.refused = text;
    std::vector<Fallback> no_worse;
    for (const auto& [make, name] : kFallbacks) {
      std::optional<Fallback> fallback = make(fallback_input());
      if (!fallback) {
        std::snprintf(text, sizeof text, "; %s: the seen points do not tell one", name);
      } else {
        const bool is_worse = fallback->contradicted > refused.hypothesis.contradicted;
        if (!is_worse && fallback->score() <= kGoodFallbackScore) return use(*fallback);
        std::snprintf(text, sizeof text, "; %s: against %.0f %%, misfit %.2f", name,
                      100 * fallback->contradicted, fallback->misfit);
        if (!is_worse) no_worse.push_back(std::move(*fallback));
      }
      shape_.refused += text;
    }
    if (no_worse.empty()) {
      shape_.refused += "; so the mirror after all";
      shape_.method = shape_.evidence.method = CompletionMethod::kRefusedMirror;
      return mirror(ballot, refused);
    }
    use(*std::min_element(
        no_worse.begin(), no_worse.end(),
        [](const Fallback& a, const Fallback& b) { return a.score() < b.score(); }));
  }

  void use(const Fallback& fallback) {
    shape_.method = fallback.method;
    Evidence& e = shape_.evidence;
    e.method = fallback.method;
    e.contradiction = fallback.score();
    e.contradicted = fallback.contradicted;
    e.coincident = fallback.coincident;
    e.unseen = fallback.unseen;
    e.support = fallback.coincident + fallback.contradicted > 0
                    ? fallback.coincident / (fallback.coincident + fallback.contradicted)
                    : 0.5;
    // A nominal plane through the middle, so that far points have a viewpoint to be seen from.
    const Eigen::Vector2d away = voting_.away_T;
    shape_.symmetry = {};
    shape_.symmetry.point_W =
        voting_.X_WT * Eigen::Vector3d(fallback.center_T.x(), fallback.center_T.y(), 0);
    shape_.symmetry.normal_W = voting_.X_WT.linear() * Eigen::Vector3d(away.x(), away.y(), 0);
    shape_.symmetry.vote = fallback.score();
    shape_.symmetry.contradicted = fallback.contradicted;
    shape_.symmetry.coincident = fallback.coincident;
    shape_.symmetry.unseen = fallback.unseen;
    shape_.mirrored_viewpoint_W = mirrored(shape_.symmetry, shape_.viewpoint_W);
    shape_.cloud_W.normals.assign(shape_.cloud_W.size(), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < fallback.points_T.size(); ++i) {
      const Eigen::Vector3d& p_T = fallback.points_T[i];
      const bool far = (p_T.head<2>() - fallback.center_T).dot(away) > 0;
      // Where something was seen the seen points tell more.
      const PointEvidence about = evidence_about(map_, view_.camera, X_CW_ * (voting_.X_WT * p_T),
                                                 options_.depth_tolerance);
      if (about.coincident > 0) continue;
      if (!append(voting_.X_WT * p_T,
                  far ? PointOrigin::kMirrored : PointOrigin::kMirroredSecond)) {
        continue;
      }
      const Eigen::Vector3d normal_W = voting_.X_WT.linear() * fallback.normals_T[i];
      shape_.cloud_W.normals.push_back(normal_W.cast<float>());
      if (!shape_.cloud_W.colors.empty()) {
        shape_.cloud_W.colors.push_back(shape_.cloud_W.colors.front());
      }
    }
  }

  void set_confidence() {
    constexpr double kSeen = 0.95;  // of a seen point; noise and bad matches are the rest
    double behind = 0, predicted = 0;
    for (std::size_t i = 0; i < behind_.size(); ++i) {
      if (shape_.support[i] == PointSupport::kSeen) continue;
      behind += static_cast<double>(behind_[i]);
      predicted += 1;
    }
    shape_.evidence.guessed_depth = predicted > 0 ? behind / predicted : 0;
    shape_.confidence = confidence(shape_.evidence, model_);
    shape_.point_confidence.reserve(shape_.cloud_W.size());
    for (std::size_t i = 0; i < shape_.cloud_W.size(); ++i) {
      double sure = shape_.confidence;
      switch (shape_.support[i]) {
        case PointSupport::kSeen:
          sure = kSeen;
          break;
        case PointSupport::kSupported:
          sure = std::max(sure, 0.5 * (kSeen + sure));
          break;
        case PointSupport::kOccluded:
          // Falls off to half with the depth behind what was seen, as in the authors' program.
          sure *= 1 - 0.5 * std::min(1.0, behind_[i] / voting_.extent);
          break;
        case PointSupport::kUnseen:
          sure *= 0.5;
          break;
      }
      shape_.point_confidence.push_back(static_cast<float>(sure));
    }
    set_region_confidence(shape_);
  }

  static constexpr double kGoodFallbackScore = 0.25;
  static constexpr std::array kFallbacks{std::pair{&revolved, "rotation"},
                                         std::pair{&extruded, "extrusion"},
                                         std::pair{&hulled, "convex hull"}};

  const ObjectView& view_;
  const CompletionOptions& options_;
  const ConfidenceModel& model_;
  geometry::RigidTransform X_CW_;
  VotingPoints voting_;
  SeenMap map_;
  CompletedShape shape_;
  std::vector<float> behind_;  // one per point: depth behind the seen surface [m]
};

}  // namespace

CompletedShape complete_by_symmetry(const ObjectView& view, const CompletionOptions& options,
                                    const ConfidenceModel& model) {
  check(options);
  VotingPoints voting = make_voting_points(view, options.thinning);
  check_view(view);
  if (options.fill_holes == 0) return Completion(view, std::move(voting), options, model).run();
  const geometry::MaskImage mask = with_holes_filled(view.mask, options.fill_holes);
  const ObjectView filled{view.cloud_W,        mask,        view.camera,     view.X_WC,
                          view.table_W,        view.nearer, view.on_another, view.depth,
                          view.may_be_several, view.is_cut};
  return Completion(filled, std::move(voting), options, model).run();
}

}  // namespace prehend::shape
