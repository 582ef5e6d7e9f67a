#include "prehend/grasp/planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "prehend/grasp/closing/closing_registry.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/grasp/parallel.h"
#include "prehend/grasp/refined_grasps.h"
#include "prehend/grasp/surface_trust.h"

namespace prehend::grasp {
namespace {

constexpr double kGoodPart = 0.25;  // of a finger's contact that was seen: it knows where it is

using std::chrono::steady_clock;

struct Tried {
  std::string generator;
  const robot::Preshape* preshape = nullptr;
  Candidate candidate;
};

/// A shape that the object has, or may have, and the hand that closes on it.
struct OnShape {
  Solid solid;
  geometry::MeshQuery query_W;
  std::unique_ptr<Closing> closing;
};

// What is too wide by the prediction comes after all that fits: before it is tried its score may be
// the best of all, but nothing of it is robust.
bool better(const Listed& a, const Listed& b) {
  if (a.is_too_wide() != b.is_too_wide()) return b.is_too_wide();
  const double of_a = a.grasp().score, of_b = b.grasp().score;
  return of_a != of_b ? of_a > of_b : a.order < b.order;
}

class Planner {
 public:
  Planner(const surface::ObjectModel& object, const geometry::Plane& table,
          const Obstacles& obstacles, const HandToClose& hand, const Reachability& reachability,
          const PlannerOptions& options)
      : object_(object),
        table_(table),
        hand_(hand),
        reachability_(reachability),
        options_(options),
        on_object_(closing_on(object.mesh_W, obstacles)),
        closing_(on_object_->closing.get()),
        disturbances_(disturbances(options.uncertainty)),
        start_(steady_clock::now()) {
    for (const auto& name : options.preshapes) preshapes_.push_back(&hand.hand->preshape(name));
    if (options.preshapes.empty()) {
      for (const auto& preshape : hand.hand->preshapes) preshapes_.push_back(&preshape);
    }
  }

  GraspPlan plan();
  /// Whether candidates of plan() were refused for the load alone.
  bool was_too_heavy() const {
    return ledger_.count(Reason::kTooHeavy) + ledger_.count(Reason::kTooWeak) > 0;
  }
  double seconds() const {  // since the start
    return std::chrono::duration<double>(steady_clock::now() - start_).count();
  }

 private:
  // On the heap, as the closing refers to the rest.
  std::unique_ptr<OnShape> closing_on(const geometry::TriangleMesh& mesh_W,
                                      const Obstacles& obstacles) const {
    Solid solid = make_solid(mesh_W, options_.density);
    geometry::MeshQuery query_W(solid.mesh_W);
    auto on_shape =
        std::make_unique<OnShape>(OnShape{std::move(solid), std::move(query_W), nullptr});
    on_shape->closing = make_closing(
        {on_shape->solid, on_shape->query_W, table_, obstacles, hand_, reachability_, options_});
    return on_shape;
  }
  bool time_is_up() const { return options_.budget > 0 && seconds() > options_.budget; }
  std::vector<Tried> given() const;
  std::vector<Tried> candidates(const std::vector<std::string>& generators) const;
  std::vector<Listed> evaluated(const std::vector<Tried>& tried, std::size_t order,
                                std::size_t begin, std::size_t end);
  std::vector<Listed> best_of(std::vector<Listed> listed);
  std::vector<Listed> ranked(std::vector<Listed> listed);
  std::vector<Listed> searched(const std::vector<Tried>& tried, std::size_t order);
  std::optional<Refusal> assess_surface(ClosedGrasp* closed) const;
  void assess_robustness(std::vector<Listed>* best);
  bool are_enough(const std::vector<Listed>& best) const;
  bool is_robust(const std::vector<Listed>& best) const;
  std::string problem(int candidates) const;

  const surface::ObjectModel& object_;
  geometry::Plane table_;
  const HandToClose& hand_;
  const Reachability& reachability_;
  const PlannerOptions& options_;
  const Obstacles nowhere_;  // in the way of other shapes: they were of the object's
  std::unique_ptr<OnShape> on_object_;
  const Closing* closing_;
  std::vector<Disturbance> disturbances_;
  steady_clock::time_point start_;
  std::vector<const robot::Preshape*> preshapes_;
  std::vector<std::unique_ptr<OnShape>> alternatives_;  // once robustness is assessed
  RefinedGrasps refined_;
  Ledger ledger_;
  double narrowest_ = std::numeric_limits<double>::infinity();  // m, outline in reachable views
};

std::vector<Tried> Planner::given() const {
  std::vector<Tried> all;
  for (const HandCandidate& one : options_.given_W) {
    all.push_back({kGiven,
                   one.preshape.empty() ? &hand_.hand->preshapes.front()
                                        : &hand_.hand->preshape(one.preshape),
                   one.candidate});
  }
  return all;
}

std::vector<Tried> Planner::candidates(const std::vector<std::string>& generators) const {
  std::vector<Tried> all;
  // Looked at once for all preshapes.
  std::vector<ApproachView> views;
  const Eigen::Vector3d& centroid_W = on_object_->solid.center_of_mass_W;
  const bool circles =
      std::find(generators.begin(), generators.end(), "circles") != generators.end();
  if (circles) {
    views = approach_views(on_object_->query_W.mesh(), centroid_W, table_, reachability_,
                           options_.candidates.circles);
  }
  for (const robot::Preshape* preshape : preshapes_) {
    const GraspTarget target{on_object_->query_W,        centroid_W,    table_,
                             closing_->reach(*preshape), reachability_, circles ? &views : nullptr};
    for (const std::string& name : generators) {
      const auto generator = make_generator(name);
      for (const Candidate& candidate : generator->generate(target, options_.candidates)) {
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

// Those from `begin` to `end` of an order whose first ones are spread over all candidates.
std::vector<Listed> Planner::evaluated(const std::vector<Tried>& tried, std::size_t order,
                                       std::size_t begin, std::size_t end) {
  const std::size_t stride = spreading_stride(tried.size());
  std::vector<std::size_t> chosen;
  for (std::size_t i = begin; i < end; ++i) chosen.push_back(i * stride % tried.size());
  // Neighbours after one another look at the same places; but time may end before the last.
  if (options_.budget <= 0) std::sort(chosen.begin(), chosen.end());
  struct Outcome {  // neither: there was no time
    std::optional<ClosedGrasp> closed;
    std::optional<Refusal> refusal;
  };
  std::vector<Outcome> outcomes(chosen.size());
  for_each_index(chosen.size(), options_.threads, [&](std::size_t i) {
    if (time_is_up()) return;
    const Tried& one = tried[chosen[i]];
    ClosedGrasp closed;
    outcomes[i].refusal = closing_->evaluate(one.candidate, *one.preshape, &closed);
    if (!outcomes[i].refusal) outcomes[i].closed = std::move(closed);
  });
  std::vector<Listed> listed;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const std::size_t at = chosen[i];
    const std::string& generator = tried[at].generator;
    Outcome& outcome = outcomes[i];
    if (!outcome.closed && !outcome.refusal) {
      ledger_.reject(Reason::kNoTime, generator);
      continue;
    }
    // Circles measure the whole outline, other generators what they hold of it.
    if (generator == "circles" && reachability_.reaches_direction(tried[at].candidate.approach_W)) {
      narrowest_ = std::min(narrowest_, tried[at].candidate.outline_width);
    }
    if (outcome.refusal) {
      ledger_.reject(outcome.refusal->reason, generator, outcome.refusal->miss);
    } else {
      outcome.closed->grasp.generator = generator;
      listed.push_back({std::move(*outcome.closed), order + at});
    }
  }
  return listed;
}

// How much of the contact is on surface that was seen, and that is there: by force where it is
// known. A finger knows where its side is if it stands on a good part that was seen: an object that
// all fingers know so is as wide as the prediction says, and is refused if that does not fit.
std::optional<Refusal> Planner::assess_surface(ClosedGrasp* closed) const {
  Grasp& grasp = closed->grasp;
  double sum = 0, guessed = 0, there = 0;
  struct Finger {
    double sum = 0, seen = 0;
  };
  std::map<int, Finger> fingers;
  for (const GraspContact& contact : grasp.contacts) {
    const auto trust = surface_trust(object_, on_object_->query_W, contact.contact_W.point);
    if (!trust) continue;
    const double weight = contact.force > 0 ? contact.force : 1;
    sum += weight;
    guessed += trust->unseen * weight;
    there += trust->there * weight;
    Finger& finger = fingers[contact.finger];
    finger.sum += weight;
    finger.seen += (1 - trust->unseen) * weight;
  }
  if (sum <= 0) return std::nullopt;
  if (closed->too_wide && std::all_of(fingers.begin(), fingers.end(), [](const auto& one) {
        return one.second.seen >= kGoodPart * one.second.sum;
      })) {
    return Refusal{Reason::kTooWide, closed->too_wide};
  }
  grasp.guessed_contact = std::min(1.0, guessed / sum);
  grasp.score *= 1 - options_.guessed_weight * (1 - std::min(1.0, there / sum));
  if (grasp.guessed_contact > 0.005) {
    add_remark(fmt::format("{:.0f} % of the contact is on surface that nobody saw",
                           100 * grasp.guessed_contact),
               &grasp.remark);
  }
  return std::nullopt;
}

// The best `largest_count` by their true scores. As these take longest, only the best by the scores
// before are refined, as many at once as may still be needed: until there are enough or, where the
// scores before are upper bounds, until the next bound is below what is kept.
std::vector<Listed> Planner::best_of(std::vector<Listed> listed) {
  std::sort(listed.begin(), listed.end(), better);
  const auto largest = static_cast<std::size_t>(options_.largest_count);
  std::vector<Listed> best;
  std::vector<double> kept;  // scores of the best so far, best first
  const auto is_enough = [&](const Listed& next) {
    return kept.size() >= largest && (!closing_->bounds_score() || next.is_too_wide() ||
                                      kept[largest - 1] >= next.grasp().score);
  };
  const auto is_same = [&](const Listed& a, const Listed& b) {
    return closing_->same(a.grasp(), b.grasp());
  };
  std::size_t first = 0;
  while (first < listed.size() && !is_enough(listed[first])) {
    const std::size_t wanted = std::max<std::size_t>(1, largest - std::min(largest, best.size()));
    std::vector<std::size_t> next;  // that are not known yet, and differ from one another
    std::size_t last = first;
    for (; last < listed.size() && next.size() < wanted; ++last) {
      const auto like = [&](const Listed& other) { return is_same(listed[last], other); };
      if (std::any_of(best.begin(), best.end(), like)) continue;
      if (std::any_of(next.begin(), next.end(),
                      [&](std::size_t other) { return like(listed[other]); })) {
        break;  // known if that one is strong
      }
      next.push_back(last);
    }
    std::vector<Listed*> to_refine;
    for (const std::size_t i : next) to_refine.push_back(&listed[i]);
    refined_.refine(to_refine, *closing_, options_.threads);
    for (std::size_t i = first, refined = 0; i < last; ++i) {
      Listed& one = listed[i];
      if (refined == next.size() || next[refined] != i) {
        ledger_.reject(Reason::kSame, one.grasp().generator);
        continue;
      }
      ++refined;
      const auto& refusal = refined_.refusal(one);
      const auto refused = refusal ? refusal : assess_surface(&one.closed);
      if (refused) {
        ledger_.reject(refused->reason, one.grasp().generator, refused->miss);
      } else {
        kept.insert(std::upper_bound(kept.begin(), kept.end(), one.grasp().score, std::greater<>()),
                    one.grasp().score);
        best.push_back(std::move(one));
      }
    }
    first = last;
  }
  std::sort(best.begin(), best.end(), better);
  for (std::size_t i = largest; i < best.size(); ++i) {
    ledger_.reject(Reason::kRankedBelow, best[i].grasp().generator);
  }
  if (best.size() > largest) best.resize(largest);
  for (; first < listed.size(); ++first) {
    ledger_.reject(Reason::kRankedBelow, listed[first].grasp().generator);
  }
  return best;
}

// Who is assessed no more counts as if nothing held.
void Planner::assess_robustness(std::vector<Listed>* best) {
  for (std::size_t i = alternatives_.size(); i < object_.alternatives_W.size(); ++i) {
    alternatives_.push_back(closing_on(object_.alternatives_W[i], nowhere_));
  }
  std::vector<const Closing*> on_shapes{closing_};
  for (const auto& one : alternatives_) on_shapes.push_back(one->closing.get());
  std::vector<Listed*> assessed;
  for (Listed& one : *best) {
    if (options_.robust_count > 0 && static_cast<int>(assessed.size()) == options_.robust_count) {
      break;
    }
    assessed.push_back(&one);
  }
  refined_.assess(assessed, on_shapes, shape_weights(object_), disturbances_, options_.threads,
                  [this] { return time_is_up(); });
  for (Listed& one : *best) {
    Grasp& grasp = one.grasp();
    grasp.score *= 1 - options_.robust_weight * (1 - std::max(0.0, grasp.robustness));
  }
}

bool Planner::are_enough(const std::vector<Listed>& best) const {
  const auto sure = std::count_if(best.begin(), best.end(), [](const Listed& one) {
    return !one.is_too_wide() && one.grasp().robustness >= PlannerOptions::kSure;
  });
  return options_.enough_grasps > 0 && static_cast<int>(best.size()) >= options_.largest_count &&
         sure >= std::min(options_.enough_grasps, options_.largest_count);
}

bool Planner::is_robust(const std::vector<Listed>& best) const {
  return std::any_of(best.begin(), best.end(), [this](const Listed& one) {
    return disturbances_.empty() || one.grasp().robustness >= options_.enough;
  });
}

// The best of these, best first.
std::vector<Listed> Planner::ranked(std::vector<Listed> listed) {
  std::vector<Listed> best = best_of(std::move(listed));
  if (disturbances_.empty() || best.empty()) return best;
  assess_robustness(&best);
  std::sort(best.begin(), best.end(), better);
  return best;
}

// The best of these candidates, or enough of a share of them: the first share is what would be
// found of fewer candidates, the last one the same as without shares. `order` is of the first
// candidate among all.
std::vector<Listed> Planner::searched(const std::vector<Tried>& tried, std::size_t order) {
  std::vector<Listed> listed;
  std::size_t begin = 0;
  const auto try_until = [&](std::size_t end) {
    for (Listed& one : evaluated(tried, order, begin, end)) listed.push_back(std::move(one));
    begin = end;
  };
  for (int share = options_.first_share; share > 1; share /= 2) {
    if (disturbances_.empty() || options_.enough_grasps == 0) break;
    try_until(tried.size() / static_cast<std::size_t>(share));
    if (static_cast<int>(listed.size()) < options_.largest_count) continue;
    const Ledger before = ledger_;
    std::vector<Listed> best = ranked(listed);
    if (are_enough(best)) {
      const std::size_t stride = spreading_stride(tried.size());
      for (; begin < tried.size(); ++begin) {
        ledger_.reject(Reason::kEnough, tried[begin * stride % tried.size()].generator);
      }
      return best;
    }
    ledger_ = before;
  }
  try_until(tried.size());
  return ranked(std::move(listed));
}

// The one reason to tell: out of reach, too wide, or the last test that at least a tenth of the
// reachable candidates got to.
std::string Planner::problem(int candidates) const {
  const int reachable =
      candidates - ledger_.count(Reason::kDirection) - ledger_.count(Reason::kWorkspace);
  if (reachable == 0) return "no approach to it is within the robot's reach";
  if (std::isfinite(narrowest_)) {
    if (const std::string wide = closing_->too_wide(narrowest_); !wide.empty()) return wide;
  }
  Reason last = Reason::kNoTime;
  for (const Reason stage : closing_->stages()) {
    if (stage != Reason::kDirection && stage != Reason::kWorkspace &&
        10 * ledger_.count(stage) >= reachable) {
      last = stage;
    }
  }
  if (const std::string figures = closing_->explain(last); !figures.empty()) return figures;
  return fmt::format("{} ({} of {} reachable candidates)", to_string(last), ledger_.count(last),
                     reachable);
}

GraspPlan Planner::plan() {
  std::vector<Tried> tried = given();
  const bool is_given = !tried.empty();
  if (!is_given) tried = candidates(options_.generators);
  GraspPlan result;
  result.candidates = static_cast<int>(tried.size());
  std::vector<Listed> best =
      is_given ? ranked(evaluated(tried, 0, 0, tried.size())) : searched(tried, 0);
  if (!is_given && !is_robust(best) && !time_is_up()) {
    const std::vector<Tried> further = candidates(options_.further_generators);
    result.candidates += static_cast<int>(further.size());
    for (Listed& one : searched(further, tried.size())) best.push_back(std::move(one));
    std::sort(best.begin(), best.end(), better);
    while (static_cast<int>(best.size()) > options_.largest_count) {
      ledger_.reject(Reason::kRankedBelow, best.back().grasp().generator);
      best.pop_back();
    }
  }
  for (Listed& one : best) result.grasps.push_back(std::move(one.grasp()));
  result.rejections = ledger_.rejections(closing_->stages());
  result.outcome = result.grasps.empty() ? PlanOutcome::kUngraspable : PlanOutcome::kGraspable;
  if (result.grasps.empty()) result.problem = problem(result.candidates);
  return result;
}

}  // namespace

std::vector<Eigen::Vector3d> contact_points(const Grasp& grasp) {
  std::vector<Eigen::Vector3d> points;
  for (const GraspContact& contact : grasp.contacts) points.push_back(contact.contact_W.point);
  return points;
}

GraspPlan plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                      const Obstacles& obstacles, const HandToClose& hand,
                      const Reachability& reachability, const PlannerOptions& options) {
  options.validate();
  Planner planner(object, table, obstacles, hand, reachability, options);
  GraspPlan plan = planner.plan();
  if (!plan.grasps.empty() || !planner.was_too_heavy() || options.hollow_share >= 1) return plan;
  PlannerOptions lighter = options;
  lighter.density *= options.hollow_share;
  if (options.budget > 0) {
    lighter.budget = options.budget - planner.seconds();
    if (lighter.budget <= 0) return plan;
  }
  GraspPlan light = Planner(object, table, obstacles, hand, reachability, lighter).plan();
  // What holds in no disturbed trial even so is not worth the doubt.
  const bool is_tried = options.uncertainty.samples > 0;
  if (light.grasps.empty() || (is_tried && light.grasps.front().robustness <= 0)) return plan;
  for (Grasp& grasp : light.grasps) {
    add_remark(fmt::format("too heavy with {:.0f} kg/m^3: planned with {:.0f}", options.density,
                           lighter.density),
               &grasp.remark);
  }
  return light;
}

GraspPlan plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                      const Obstacles& obstacles, const robot::GripperModel& gripper,
                      const Reachability& reachability, const PlannerOptions& options) {
  const robot::HandModel hand = robot::parallel_hand(gripper);
  return plan_grasps(object, table, obstacles, HandToClose(hand), reachability, options);
}

}  // namespace prehend::grasp
