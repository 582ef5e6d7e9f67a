#include "prehend/planning/remedies.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "prehend/planning/remedy_levers.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using std::chrono::steady_clock;

// More are not told in the one sentence of in_words().
constexpr std::size_t kToldInWords = 3;
constexpr int kMostCounted = 10000;

// What was tried when the time was up, is not known.
class RemedyTime {
 public:
  explicit RemedyTime(double budget) : budget_(budget) {}
  double left() const {
    return budget_ - std::chrono::duration<double>(steady_clock::now() - begin_).count();
  }

 private:
  double budget_;
  steady_clock::time_point begin_ = steady_clock::now();
};

struct TimeIsUp {};

void check_remedy_options(const RemedyOptions& options) {
  const text::Require require{"RemedyOptions."};
  RemedyOptions::knobs(options, text::CheckKnobs{require.of});
}

std::string grasps_text(int grasps) {
  return fmt::format("{} grasp{}", grasps, grasps == 1 ? "" : "s");
}

// Eight, counter-clockwise from +x.
Eigen::Vector3d compass(int k) {
  const double angle = k * std::numbers::pi / 4;
  return {std::cos(angle), std::sin(angle), 0};
}

std::string moved_text(double distance, const Eigen::Vector3d& direction_W) {
  // -0 is 0.
  const Eigen::Vector3d way_mm = (1e3 * distance * direction_W).array().round() + 0.0;
  return fmt::format("the object moved by x {:.0f} mm, y {:.0f} mm", way_mm.x(), way_mm.y());
}

class GraspRemedies {
 public:
  GraspRemedies(GraspCase planned, const std::vector<grasp::Rejection>& ledger, double budget)
      : planned_(std::move(planned)), ledger_(ledger), time_(budget) {
    grasp::PlannerOptions& options = planned_.options;
    options.uncertainty.samples = 0;
    options.pads.width_tolerance = 0;
    as_given_ = planned_;
    levers_ = levers_for(as_given_, ledger_);
    // Levers have looked at it: from here on the object has its density as a whole.
    options.hollow_share = 1;
  }

  Remedies find() {
    try {
      for (const Lever& lever : levers_) {
        if (auto steps = least_steps(lever, planned_)) {
          add({&lever}, {*steps});
        } else {
          result_.in_vain.push_back(lever.text(lever.most));
        }
      }
      move_object();
      if (result_.found.empty()) find_pairs();
    } catch (const TimeIsUp&) {
      result_.complete = false;
    }
    return std::move(result_);
  }

 private:
  grasp::GraspPlan plan(const GraspCase& changed, int largest_count) const {
    GraspCase timed = changed;
    timed.options.budget = time_.left();
    timed.options.largest_count = largest_count;
    if (timed.options.budget <= 0) throw TimeIsUp();
    grasp::GraspPlan plan =
        grasp::plan_grasps(*timed.object, timed.table_W, *timed.obstacles,
                           grasp::HandToClose(timed.hand), timed.reachability, timed.options);
    if (time_.left() <= 0) throw TimeIsUp();
    return plan;
  }
  bool has_grasp(const Lever& lever, int steps, GraspCase changed) const {
    lever.pull(steps, &changed);
    return !plan(changed, 1).grasps.empty();
  }

  // None: not even the most helps.
  std::optional<int> least_steps(const Lever& lever, const GraspCase& from) const {
    int without = lever.first - 1, with = lever.first;
    if (!has_grasp(lever, with, from)) {
      without = with;
      with = lever.most;
      if (without == with || !has_grasp(lever, with, from)) return std::nullopt;
    } else if (lever.first > 1) {
      // What is nearest in the ledger need not be the first to pass: of another generator, or
      // after another test.
      without = 0;
    }
    while (with - without > 1) {
      const int middle = (without + with) / 2;
      (has_grasp(lever, middle, from) ? with : without) = middle;
    }
    return with;
  }

  void add(const std::vector<const Lever*>& levers, const std::vector<int>& steps) {
    GraspCase changed = planned_;
    Remedy remedy;
    std::string with;
    bool any_side = false;
    for (std::size_t i = 0; i < levers.size(); ++i) {
      const Lever& lever = *levers[i];
      lever.pull(steps[i], &changed);
      remedy.amounts.push_back({lever.change, lever.planned, lever.value(steps[i])});
      with += (i > 0 ? " and " : "") + lever.text(steps[i]);
      any_side = any_side || (lever.change == RemedyChange::kApproach &&
                              planned_.reachability.approach_W.has_value());
    }
    const grasp::GraspPlan plan = this->plan(changed, kMostCounted);
    remedy.grasps = static_cast<int>(plan.grasps.size());
    remedy.text = "with " + with + ": " + grasps_text(remedy.grasps);
    if (any_side) remedy.text += tilt_text(plan.grasps.front());
    result_.found.push_back(std::move(remedy));
  }

  std::string tilt_text(const grasp::Grasp& best) const {
    const Eigen::Vector3d& planned_W = *planned_.reachability.approach_W;
    const double angle =
        std::atan2(planned_W.cross(best.approach_W).norm(), planned_W.dot(best.approach_W));
    return fmt::format(", the best tilted by {:.0f} deg", angle * 180 / std::numbers::pi);
  }

  // Two together: the second is what the ledger names with the first at its most. The first as
  // little as the second at its most lets it be, then the second.
  void find_pairs() {
    std::set<std::pair<RemedyChange, RemedyChange>> tried;
    for (const Lever& a : levers_) {
      GraspCase with_a = planned_;
      a.pull(a.most, &with_a);
      for (const Lever& b : levers_for(as_given_, plan(with_a, 1).rejections)) {
        if (a.change == b.change || !tried.insert(std::minmax(a.change, b.change)).second) continue;
        GraspCase with_b = planned_;
        b.pull(b.most, &with_b);
        const auto of_a = least_steps(a, with_b);
        if (!of_a) continue;
        GraspCase with_least_a = planned_;
        a.pull(*of_a, &with_least_a);
        if (const auto of_b = least_steps(b, with_least_a)) add({&a, &b}, {*of_a, *of_b});
      }
    }
  }

  // Where the arm would reach what the hand alone can grasp: the object moved with all that stands
  // beside it.
  void move_object() {
    constexpr double kStep = 0.05;  // m
    constexpr int kSteps = 20;
    const auto fell_at_arm = [](const grasp::Rejection& one) {
      return one.reason == grasp::Reason::kArm;
    };
    const auto& reaches = planned_.options.reaches;
    if (!reaches || std::none_of(ledger_.begin(), ledger_.end(), fell_at_arm)) return;
    GraspCase without_arm = planned_;
    without_arm.options.reaches = nullptr;
    const std::vector<grasp::Grasp> grasps = plan(without_arm, kMostCounted).grasps;
    for (int step = 1; step <= kSteps && !grasps.empty(); ++step) {
      int most = 0, best = 0;
      for (int k = 0; k < 8; ++k) {
        int reached = 0;
        for (const grasp::Grasp& grasp : grasps) {
          if (time_.left() <= 0) throw TimeIsUp();
          reached += reaches_moved(grasp, step * kStep * compass(k)) ? 1 : 0;
        }
        if (reached > most) std::tie(most, best) = std::pair(reached, k);
      }
      if (most == 0) continue;
      const Eigen::Vector3d way_W = step * kStep * compass(best);
      GraspCase moved = planned_;
      moved.options.reaches = [&reaches, way_W](geometry::RigidTransform X_WH) {
        X_WH.translation() += way_W;
        return reaches(X_WH);
      };
      const int count = static_cast<int>(plan(moved, kMostCounted).grasps.size());
      result_.found.push_back(
          {{{RemedyChange::kPlace, 0, step * kStep}},
           count,
           fmt::format("with {} (and what is beside it): {}",
                       moved_text(step * kStep, compass(best)), grasps_text(count))});
      return;
    }
    result_.in_vain.push_back(
        grasps.empty() ? std::string("an arm that reaches everywhere")
                       : fmt::format("the object moved by {:.0f} mm", 1e3 * kSteps * kStep));
  }

  // As the planner asks: at the grasp and its pregrasp, pads also turned by half.
  bool reaches_moved(const grasp::Grasp& grasp, const Eigen::Vector3d& way_W) const {
    const geometry::RigidTransform X_GH = grasp.X_WG.inverse() * grasp.X_WH;
    geometry::RigidTransform turned = grasp.X_WG;
    turned.linear().leftCols<2>() *= -1;
    for (geometry::RigidTransform X_WG : {grasp.X_WG, turned}) {
      X_WG.translation() += way_W;
      geometry::RigidTransform pregrasp = X_WG;
      pregrasp.translation() -= planned_.options.pregrasp_distance * grasp.approach_W;
      if (planned_.options.reaches(X_WG * X_GH) && planned_.options.reaches(pregrasp * X_GH)) {
        return true;
      }
      if (!planned_.hand.gripper) return false;
    }
    return false;
  }

  GraspCase planned_, as_given_;  // without and with `hollow_share`
  const std::vector<grasp::Rejection>& ledger_;
  RemedyTime time_;
  std::vector<Lever> levers_;
  Remedies result_;
};

}  // namespace

const char* to_string(RemedyChange change) {
  switch (change) {
    case RemedyChange::kOpening:
      return "opening";
    case RemedyChange::kFriction:
      return "friction";
    case RemedyChange::kForce:
      return "force";
    case RemedyChange::kMass:
      return "mass";
    case RemedyChange::kMotors:
      return "motors";
    case RemedyChange::kAir:
      return "air";
    case RemedyChange::kNeighbours:
      return "neighbours";
    case RemedyChange::kApproach:
      return "approach";
    case RemedyChange::kWorkspace:
      return "workspace";
    case RemedyChange::kPlace:
      return "place";
  }
  return "";
}

std::string in_words(const Remedies& remedies) {
  std::string text;
  const auto& found = remedies.found;
  if (!found.empty()) {
    for (std::size_t i = 0; i < std::min(kToldInWords, found.size()); ++i) {
      text += (i == 0 ? "It would help: " : "; ") + found[i].text;
    }
    return text;
  }
  for (const std::string& one : remedies.in_vain) {
    text += (text.empty() ? "It would not help: " : "; ") + one;
  }
  if (!remedies.complete) {
    text +=
        text.empty() ? "What would help was not found out in time" : "; more was not tried in time";
  }
  return text;
}

Remedies remedies_for_grasps(const surface::ObjectModel& object, const geometry::Plane& table_W,
                             const grasp::Obstacles& obstacles, const robot::HandModel& hand,
                             const grasp::Reachability& reachability,
                             const grasp::PlannerOptions& options,
                             const std::vector<grasp::Rejection>& ledger,
                             const RemedyOptions& remedy_options) {
  check_remedy_options(remedy_options);
  if (remedy_options.budget <= 0) return {};
  return GraspRemedies({&object, table_W, &obstacles, hand, reachability, options}, ledger,
                       remedy_options.budget)
      .find();
}

Remedies remedies_for_motion(const robot::Platform& platform, const robot::Positions& start,
                             const std::vector<PlatformGrasp>& grasps, const PlatformScene& scene,
                             const PlatformPickOptions& options,
                             const RemedyOptions& remedy_options) {
  check_remedy_options(remedy_options);
  Remedies result;
  if (remedy_options.budget <= 0 || grasps.empty()) return result;
  const RemedyTime time(remedy_options.budget);
  const auto is_found = [&](const std::vector<PlatformGrasp>& moved, const PlatformScene& changed) {
    PlatformPickOptions timed = options;
    const double left = time.left();
    if (left <= 0) return false;
    timed.pick.budget = options.pick.budget > 0 ? std::min(options.pick.budget, left) : left;
    return plan_platform_pick(platform, start, moved, changed, timed).motion.found();
  };
  if (!scene.obstacle_pieces_W.empty()) {
    PlatformScene alone = scene;
    alone.obstacle_pieces_W.clear();
    if (is_found(grasps, alone)) {
      result.found.push_back({{{RemedyChange::kNeighbours, 1, 0}},
                              1,
                              "with nothing beside it: the arm has a way to a grasp"});
    } else {
      result.in_vain.emplace_back("nothing beside it");
    }
  }
  constexpr std::array<double, 2> kDistances{0.1, 0.2};  // m
  for (const double distance : kDistances) {
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d way_W = distance * compass(k);
      std::vector<PlatformGrasp> moved = grasps;
      for (PlatformGrasp& grasp : moved) grasp.X_WG.translation() += way_W;
      PlatformScene changed = scene;
      for (geometry::TriangleMesh& piece : changed.object_pieces_W) {
        for (Eigen::Vector3d& vertex : piece.vertices) vertex += way_W;
      }
      if (!is_found(moved, changed)) continue;
      result.found.push_back(
          {{{RemedyChange::kPlace, 0, distance}},
           1,
           fmt::format("with {}: the arm has a way to a grasp", moved_text(distance, compass(k)))});
      return result;
    }
  }
  result.complete = time.left() > 0;
  if (result.complete) {
    result.in_vain.push_back(
        fmt::format("the object moved by up to {:.0f} mm", 1e3 * kDistances.back()));
  }
  return result;
}

}  // namespace prehend::planning
