#include "prehend/grasp/hand_planner.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/grasp/hand_evaluation.h"
#include "prehend/grasp/parallel.h"
#include "prehend/grasp/surface_trust.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using std::chrono::steady_clock;

// In the order of the tests: who fails late was nearly a grasp.
constexpr std::array kHandStages{reason::kDirection,   reason::kTable,          reason::kObject,
                                 reason::kObstacle,    reason::kWorkspace,      reason::kArm,
                                 reason::kFingerTable, reason::kFingerObstacle, reason::kFewFingers,
                                 reason::kNotClosed,   reason::kFingersMeet,    reason::kTooWeak};

struct Tried {
  std::string generator;
  const robot::Preshape* preshape = nullptr;
  Candidate candidate;
};

struct ListedHandGrasp {
  HandGrasp grasp;
  std::size_t order = 0;  // of the candidate
};

/// What came of a candidate: a grasp, or why not; neither: there was no time.
struct Outcome {
  std::optional<HandGrasp> grasp;
  std::optional<Refusal> refusal;
};

bool better_grasp(const ListedHandGrasp& a, const ListedHandGrasp& b) {
  return a.grasp.score != b.grasp.score ? a.grasp.score > b.grasp.score : a.order < b.order;
}

// Different standoffs that the same contact ends are one grasp, and so are preshapes that close to
// the same.
bool same(const HandGrasp& a, const HandGrasp& b) {
  constexpr double kPosition = 2e-3, kAngle = 0.04;  // m, rad
  return (a.preshape == b.preshape ||
          (a.closed_all - b.closed_all).lpNorm<Eigen::Infinity>() < kAngle) &&
         (a.X_WH.translation() - b.X_WH.translation()).norm() < kPosition &&
         Eigen::AngleAxisd(a.X_WH.linear().transpose() * b.X_WH.linear()).angle() < kAngle;
}

class HandPlanner {
 public:
  HandPlanner(const surface::ObjectModel& object, const geometry::Plane& table,
              const Obstacles& obstacles, const HandToClose& hand, const Reachability& reachability,
              const HandPlannerOptions& options)
      : object_(object),
        evaluator_(make_solid(object.mesh_W, options.density), table, obstacles, hand, reachability,
                   options),
        table_(table),
        hand_(hand),
        reachability_(reachability),
        options_(options),
        disturbances_(disturbances(options.uncertainty)) {
    for (const auto& name : options.preshapes) preshapes_.push_back(&hand.hand->preshape(name));
    if (options.preshapes.empty()) {
      for (const auto& preshape : hand.hand->preshapes) preshapes_.push_back(&preshape);
    }
  }

  HandPlan plan();

 private:
  std::vector<Tried> candidates(const std::vector<std::string>& generators) const;
  std::vector<ListedHandGrasp> ranked(const std::vector<Tried>& tried, std::size_t order,
                                      const std::function<bool()>& time_is_up,
                                      Ledger* ledger) const;
  bool is_robust(const std::vector<ListedHandGrasp>& best) const;
  std::vector<ListedHandGrasp> strongest(std::vector<ListedHandGrasp> listed, Ledger* ledger) const;
  void assess_robustness(std::vector<ListedHandGrasp>* best,
                         const std::function<bool()>& time_is_up) const;
  void assess_surface(HandGrasp* grasp) const;
  std::string problem(const HandPlan& result, const Ledger& ledger) const;

  const surface::ObjectModel& object_;
  HandEvaluator evaluator_;
  geometry::Plane table_;
  const HandToClose& hand_;
  const Reachability& reachability_;
  const HandPlannerOptions& options_;
  std::vector<Disturbance> disturbances_;
  std::vector<const robot::Preshape*> preshapes_;
};

std::vector<Tried> HandPlanner::candidates(const std::vector<std::string>& generators) const {
  std::vector<Tried> all;
  // Looked at once for all preshapes.
  std::vector<ApproachView> views;
  const Eigen::Vector3d& centroid_W = evaluator_.solid().center_of_mass_W;
  const bool circles =
      std::find(generators.begin(), generators.end(), "circles") != generators.end();
  if (circles) {
    views = approach_views(evaluator_.query().mesh(), centroid_W, table_, reachability_,
                           options_.candidates.circles);
  }
  for (const robot::Preshape* preshape : preshapes_) {
    const GraspTarget target{
        evaluator_.query(),           centroid_W,    table_,
        hand_reach(hand_, *preshape), reachability_, circles ? &views : nullptr};
    for (const std::string& name : generators) {
      const auto generator = make_generator(name, options_.candidates);
      for (const Candidate& candidate : generator->generate(target)) {
        all.push_back({name, preshape, candidate});
        if (!options_.both_ways) continue;
        Candidate turned = candidate;
        turned.X_WG.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
        turned.roll += std::numbers::pi;
        all.push_back({name, preshape, turned});
      }
    }
  }
  return all;
}

// How many of the contacts are on surface that nobody saw, and on surface that is there.
void HandPlanner::assess_surface(HandGrasp* grasp) const {
  double there = 0;
  for (const HandContact& contact : grasp->contacts) {
    const auto trust = surface_trust(object_, evaluator_.query(), contact.contact_W.point);
    if (!trust) return;
    grasp->guessed_contact += trust->unseen / static_cast<double>(grasp->contacts.size());
    there += trust->there / static_cast<double>(grasp->contacts.size());
  }
  grasp->score *= 1 - options_.weights.guessed * (1 - std::min(1.0, there));
  if (grasp->guessed_contact > 0.005) {
    grasp->remark = fmt::format("{:.0f} % of the contacts are on surface that nobody saw",
                                100 * std::min(1.0, grasp->guessed_contact));
  }
}

// The best of a sorted list whose forces the motors have. Forces take longest: of the best alone,
// until there are enough; as many at once as may still be needed.
std::vector<ListedHandGrasp> HandPlanner::strongest(std::vector<ListedHandGrasp> listed,
                                                    Ledger* ledger) const {
  const auto largest = static_cast<std::size_t>(options_.largest_count);
  std::vector<ListedHandGrasp> best;
  const auto is_known = [&best](const ListedHandGrasp& one) {
    return std::any_of(best.begin(), best.end(), [&one](const ListedHandGrasp& other) {
      return same(one.grasp, other.grasp);
    });
  };
  for (std::size_t first = 0; first < listed.size();) {
    if (best.size() == largest) {
      ledger->reject(reason::kRankedBelow, listed[first++].grasp.generator);
      continue;
    }
    std::vector<std::size_t> next;  // that are not known yet, and differ from one another
    std::size_t last = first;
    for (; last < listed.size() && best.size() + next.size() < largest; ++last) {
      if (is_known(listed[last])) continue;
      const auto is_same = [&](std::size_t other) {
        return same(listed[last].grasp, listed[other].grasp);
      };
      if (std::any_of(next.begin(), next.end(), is_same)) break;  // known if that one is strong
      next.push_back(last);
    }
    std::vector<std::optional<Refusal>> refusals(next.size());
    for_each_index(next.size(), options_.threads, [&](std::size_t i) {
      refusals[i] = evaluator_.assess_forces(&listed[next[i]].grasp);
    });
    for (std::size_t i = first, assessed = 0; i < last; ++i) {
      ListedHandGrasp& one = listed[i];
      if (assessed == next.size() || next[assessed] != i) {
        ledger->reject(reason::kSame, one.grasp.generator);
      } else if (const auto& refusal = refusals[assessed++]) {
        ledger->reject(refusal->reason, one.grasp.generator, refusal->miss);
      } else {
        one.grasp.score = evaluator_.score(one.grasp);
        assess_surface(&one.grasp);
        best.push_back(std::move(one));
      }
    }
    first = last;
  }
  return best;
}

// Who is assessed no more counts as if nothing held.
void HandPlanner::assess_robustness(std::vector<ListedHandGrasp>* best,
                                    const std::function<bool()>& time_is_up) const {
  std::deque<HandEvaluator> alternatives;
  for (const auto& mesh_W : object_.alternatives_W) {
    alternatives.emplace_back(make_solid(mesh_W, options_.density), table_, Obstacles{}, hand_,
                              reachability_, options_);
  }
  const std::size_t assessed =
      std::min(best->size(), static_cast<std::size_t>(options_.robust_count));
  const std::size_t samples = disturbances_.size();
  std::vector<std::optional<bool>> held(assessed * samples);
  for_each_index(held.size(), options_.threads, [&](std::size_t i) {
    if (time_is_up()) return;
    const HandGrasp& grasp = (*best)[i / samples].grasp;
    const Disturbance& one = disturbances_[i % samples];
    const std::size_t shape = i % samples % (alternatives.size() + 1);
    const HandEvaluator& evaluator = shape == 0 ? evaluator_ : alternatives[shape - 1];
    const RigidTransform X_GH = grasp.X_WG.inverse() * grasp.X_WH;
    held[i] = evaluator.holds(grasp, grasp.X_WG * one.X_GD * X_GH, one.friction);
  });
  for (std::size_t g = 0; g < best->size(); ++g) {
    HandGrasp& grasp = (*best)[g].grasp;
    if (g < assessed) {
      grasp.robustness = share_held(held, g * samples, samples).value_or(grasp.robustness);
    }
    grasp.score *= 1 - options_.weights.robust * (1 - std::max(0.0, grasp.robustness));
  }
}

// The one reason to tell: the last test that at least a tenth of the candidates got to.
std::string HandPlanner::problem(const HandPlan& result, const Ledger& ledger) const {
  const int reachable = result.candidates - ledger.count(reason::kDirection);
  if (reachable == 0) return "cannot be grasped: no approach to it is within the robot's reach";
  const char* last = reason::kNoTime;
  for (const char* stage : kHandStages) {
    if (stage != reason::kDirection && 10 * ledger.count(stage) >= reachable) last = stage;
  }
  return fmt::format("cannot be grasped: {} ({} of {} reachable candidates)", last,
                     ledger.count(last), reachable);
}

// The best of these candidates, best first; `order` is of the first of them among all.
std::vector<ListedHandGrasp> HandPlanner::ranked(const std::vector<Tried>& tried, std::size_t order,
                                                 const std::function<bool()>& time_is_up,
                                                 Ledger* ledger) const {
  // With a budget in strides, so that whatever is tried is spread over all candidates.
  const std::size_t stride = options_.budget > 0 ? spreading_stride(tried.size()) : 1;
  std::vector<Outcome> outcomes(tried.size());
  for_each_index(tried.size(), options_.threads, [&](std::size_t i) {
    if (time_is_up()) return;
    const std::size_t at = i * stride % tried.size();
    Outcome& outcome = outcomes[at];
    HandGrasp grasp;
    grasp.generator = tried[at].generator;
    outcome.refusal = evaluator_.evaluate(tried[at].candidate, *tried[at].preshape, &grasp);
    if (outcome.refusal) return;
    grasp.score = evaluator_.score(grasp);
    outcome.grasp = std::move(grasp);
  });
  std::vector<ListedHandGrasp> listed;
  for (std::size_t at = 0; at < tried.size(); ++at) {
    Outcome& outcome = outcomes[at];
    if (outcome.grasp) {
      listed.push_back({std::move(*outcome.grasp), order + at});
    } else if (outcome.refusal) {
      ledger->reject(outcome.refusal->reason, tried[at].generator, outcome.refusal->miss);
    } else {
      ledger->reject(reason::kNoTime, tried[at].generator);
    }
  }
  std::sort(listed.begin(), listed.end(), better_grasp);
  std::vector<ListedHandGrasp> best = strongest(std::move(listed), ledger);
  std::sort(best.begin(), best.end(), better_grasp);
  if (!disturbances_.empty() && !best.empty()) {
    assess_robustness(&best, time_is_up);
    std::sort(best.begin(), best.end(), better_grasp);
  }
  return best;
}

bool HandPlanner::is_robust(const std::vector<ListedHandGrasp>& best) const {
  return std::any_of(best.begin(), best.end(), [this](const ListedHandGrasp& one) {
    return disturbances_.empty() || one.grasp.robustness >= options_.enough;
  });
}

HandPlan HandPlanner::plan() {
  const auto start = steady_clock::now();
  const auto time_is_up = [&] {
    return options_.budget > 0 &&
           std::chrono::duration<double>(steady_clock::now() - start).count() > options_.budget;
  };
  std::vector<Tried> given;
  for (const HandCandidate& one : options_.given_W) {
    given.push_back({kGiven, &hand_.hand->preshape(one.preshape), one.candidate});
  }
  Ledger ledger;
  const std::vector<Tried> tried = given.empty() ? candidates(options_.generators) : given;
  HandPlan result;
  result.candidates = static_cast<int>(tried.size());
  result.mass = evaluator_.solid().mass;
  std::vector<ListedHandGrasp> best = ranked(tried, 0, time_is_up, &ledger);
  if (given.empty() && !is_robust(best) && !time_is_up()) {
    const std::vector<Tried> further = candidates(options_.further_generators);
    result.candidates += static_cast<int>(further.size());
    for (ListedHandGrasp& one : ranked(further, tried.size(), time_is_up, &ledger)) {
      best.push_back(std::move(one));
    }
    std::sort(best.begin(), best.end(), better_grasp);
    while (static_cast<int>(best.size()) > options_.largest_count) {
      ledger.reject(reason::kRankedBelow, best.back().grasp.generator);
      best.pop_back();
    }
  }
  for (ListedHandGrasp& one : best) {
    if (one.grasp.robustness < 0) add_remark(kNotAssessed, &one.grasp.remark);
    result.grasps.push_back(std::move(one.grasp));
  }
  result.rejections = ledger.rejections(kHandStages);
  if (result.grasps.empty()) result.problem = problem(result, ledger);
  return result;
}

}  // namespace

HandPlannerOptions::HandPlannerOptions() {
  candidates.circles.directions_per_circle = 12;
  candidates.circles.rolls = 6;
  candidates.circles.standoffs = 3;
  candidates.circles.lateral_offsets = {0.0};
  candidates.samples = 40;
}

void HandPlannerOptions::validate() const {
  const text::Require require{"HandPlannerOptions."};
  require(!generators.empty(), "generators must name at least one generator");
  require(enough >= 0 && enough <= 1, "enough must be within 0 and 1");
  candidates.validate();
  closing.validate();
  collision.validate();
  require(cone_edges >= 3, "cone_edges must be at least 3");
  require(density > 0, "density must be positive");
  require(safety_factor >= 1, "safety_factor must be at least 1");
  require(lift_acceleration >= 0, "lift_acceleration must not be negative");
  require(pregrasp_distance > 0, "pregrasp_distance must be positive");
  require(largest_shortfall >= 0, "largest_shortfall must not be negative");
  require(least_fingers > 0, "least_fingers must be positive");
  require(largest_count > 0, "largest_count must be positive");
  require(robust_count >= 0, "robust_count must not be negative");
  uncertainty.validate();
  require(budget >= 0, "budget must not be negative");
  const auto& w = weights;
  require(w.quality >= 0 && w.margin >= 0 && w.centredness >= 0 && w.pads >= 0 &&
              w.quality + w.margin + w.centredness + w.pads > 0,
          "weights must not be negative, nor all zero");
  require(w.guessed >= 0 && w.guessed <= 1, "weights.guessed must be within 0 and 1");
  require(w.robust >= 0 && w.robust <= 1, "weights.robust must be within 0 and 1");
}

HandReach hand_reach(const HandToClose& hand, const robot::Preshape& preshape) {
  constexpr int kSteps = 16;
  const robot::HandModel& model = *hand.hand;
  const RigidTransform X_GH = (model.X_HP * preshape.X_PG).inverse();
  HandReach reach;
  reach.tip_z = -std::numeric_limits<double>::infinity();
  double inner[2] = {std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity()};  // at +y and -y
  std::vector<RigidTransform> poses;
  Eigen::VectorXd motors = preshape.open;
  for (int step = 0; step <= kSteps; ++step) {
    // Over a right angle of closing, or until a joint is at its limit.
    const Eigen::VectorXd all = model.all_positions(motors);
    if (step > 0 && !model.limit_problem(all).empty()) break;
    model.link_poses(all, poses);
    for (const robot::Finger& finger : model.fingers) {
      for (const int link : finger.links) {
        const LinkBalls& balls = hand.balls.links[static_cast<std::size_t>(link)];
        for (std::size_t b = 0; b < balls.centers.size(); ++b) {
          const Eigen::Vector3d p_G =
              X_GH * (poses[static_cast<std::size_t>(link)] * balls.centers[b]);
          reach.tip_z = std::max(reach.tip_z, p_G.z() + balls.radii[b]);
          if (step > 0 || link != finger.links.back()) continue;
          if (p_G.y() > 0) inner[0] = std::min(inner[0], p_G.y() - balls.radii[b]);
          if (p_G.y() < 0) inner[1] = std::max(inner[1], p_G.y() + balls.radii[b]);
        }
      }
    }
    for (int i = 0; i < model.size(); ++i) {
      const bool turns =
          model.model.joints[static_cast<std::size_t>(model.actuated[static_cast<std::size_t>(i)])]
              .kind == robot::Joint::Kind::kRevolute;
      motors[i] += preshape.closing[static_cast<std::size_t>(i)].rate *
                   (turns ? std::numbers::pi / 2 : 0.1) / kSteps;
    }
  }
  reach.max_opening = std::isfinite(inner[0] - inner[1]) ? std::max(0.0, inner[0] - inner[1]) : 0;
  reach.pad_length = 0.04;
  for (const auto& pad : model.pads)
    reach.pad_length = std::max(reach.pad_length, pad.model.length());
  return reach;
}

HandPlan plan_hand_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                          const Obstacles& obstacles, const HandToClose& hand,
                          const Reachability& reachability, const HandPlannerOptions& options) {
  options.validate();
  return HandPlanner(object, table, obstacles, hand, reachability, options).plan();
}

}  // namespace prehend::grasp
