#include "prehend/grasp/planner.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/evaluation.h"
#include "prehend/grasp/parallel.h"
#include "prehend/grasp/surface_trust.h"
#include "prehend/text/require.h"
#include "prehend/text/told_apart.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using std::chrono::steady_clock;

// In the order of the tests: who fails late was nearly a grasp.
constexpr std::array kStages{reason::kDirection, reason::kNothing,    reason::kTooWide,
                             reason::kWorkspace, reason::kTable,      reason::kObject,
                             reason::kObstacle,  reason::kBottomsOut, reason::kTurns,
                             reason::kFinger,    reason::kTooHeavy,   reason::kOffCentre,
                             reason::kNotClosed};

struct Listed {
  EvaluatedGrasp evaluated;
  std::size_t order = 0;  // of the candidate
  Grasp& grasp() { return evaluated.grasp; }
  const Grasp& grasp() const { return evaluated.grasp; }
};

bool better(const Listed& a, const Listed& b) {
  const double of_a = a.grasp().score, of_b = b.grasp().score;
  return of_a != of_b ? of_a > of_b : a.order < b.order;
}

class Planner {
 public:
  Planner(const surface::ObjectModel& object, const geometry::Plane& table,
          const Obstacles& obstacles, const robot::GripperModel& gripper,
          const Reachability& reachability, const PlannerOptions& options)
      : object_(object),
        evaluator_(make_solid(object.mesh_W, options.density), table, obstacles, gripper,
                   reachability, options),
        table_(table),
        gripper_(gripper),
        reachability_(reachability),
        options_(options),
        disturbances_(disturbances(options.uncertainty)) {}

  GraspPlanResult plan();

 private:
  struct Tried {
    std::string generator;
    Candidate candidate;
  };
  std::vector<Tried> candidates(const std::vector<std::string>& generators) const;
  void examine(const std::vector<Tried>& tried, const std::function<bool()>& time_is_up,
               Ledger* ledger);
  void assess_robustness(const std::function<bool()>& time_is_up);
  void keep_best(Ledger* ledger);
  void assess_surface(EvaluatedGrasp* evaluated) const;
  std::string problem(const GraspPlanResult& result, const Ledger& ledger) const;

  const surface::ObjectModel& object_;
  GraspEvaluator evaluator_;
  geometry::Plane table_;
  const robot::GripperModel& gripper_;
  const Reachability& reachability_;
  const PlannerOptions& options_;
  std::vector<Disturbance> disturbances_;
  std::vector<Listed> listed_;
  double narrowest_ = std::numeric_limits<double>::infinity();  // m, outline in reachable views
};

std::vector<Planner::Tried> Planner::candidates(const std::vector<std::string>& generators) const {
  const Solid& solid = evaluator_.solid();
  const GraspTarget target{evaluator_.query(), solid.center_of_mass_W, table_, hand_reach(gripper_),
                           reachability_};
  std::vector<Tried> all;
  for (const std::string& name : generators) {
    const auto generator = make_generator(name, options_.candidates);
    for (const Candidate& candidate : generator->generate(target)) all.push_back({name, candidate});
  }
  return all;
}

// How much of the contact's force is on surface that was seen, and that is there.
void Planner::assess_surface(EvaluatedGrasp* evaluated) const {
  const ClosedHand& hand = evaluated->hand;
  Grasp& grasp = evaluated->grasp;
  double force = 0, guessed = 0, there = 0;
  for (const ContactPatch* patch : {&hand.left, &hand.right}) {
    for (std::size_t i = 0; i < patch->points_G.size(); ++i) {
      const auto trust =
          surface_trust(object_, evaluator_.query(), grasp.X_WG * patch->points_G[i]);
      if (!trust) continue;
      force += patch->forces[i];
      guessed += trust->unseen * patch->forces[i];
      there += trust->there * patch->forces[i];
    }
  }
  if (force <= 0) return;
  grasp.guessed_contact = std::min(1.0, guessed / force);
  grasp.score *= 1 - options_.weights.guessed * (1 - std::min(1.0, there / force));
  if (grasp.guessed_contact > 0.005) {
    grasp.remark += fmt::format("{}{:.0f} % of the contact is on surface that nobody saw",
                                grasp.remark.empty() ? "" : "; ", 100 * grasp.guessed_contact);
  }
}

// With a budget in strides, so that whatever is tried is spread over all candidates.
void Planner::examine(const std::vector<Tried>& tried, const std::function<bool()>& time_is_up,
                      Ledger* ledger) {
  const std::size_t stride = options_.budget > 0 ? spreading_stride(tried.size()) : 1;
  struct Outcome {  // neither: there was no time
    std::optional<EvaluatedGrasp> evaluated;
    std::optional<Refusal> refusal;
  };
  std::vector<Outcome> outcomes(tried.size());
  for_each_index(tried.size(), options_.threads, [&](std::size_t i) {
    if (time_is_up()) return;
    const std::size_t at = i * stride % tried.size();
    EvaluatedGrasp evaluated;
    outcomes[at].refusal = evaluator_.evaluate(tried[at].candidate, &evaluated);
    if (!outcomes[at].refusal) outcomes[at].evaluated = std::move(evaluated);
  });
  for (std::size_t at = 0; at < tried.size(); ++at) {
    const std::string& generator = tried[at].generator;
    Outcome& outcome = outcomes[at];
    if (!outcome.evaluated && !outcome.refusal) {
      ledger->reject(reason::kNoTime, generator);
      continue;
    }
    // Circles measure the whole outline, other generators what they hold of it.
    if (generator == "circles" && reachability_.reaches_direction(tried[at].candidate.approach_W)) {
      narrowest_ = std::min(narrowest_, tried[at].candidate.outline_width);
    }
    if (outcome.refusal) {
      ledger->reject(outcome.refusal->reason, generator, outcome.refusal->miss);
    } else {
      outcome.evaluated->grasp.generator = generator;
      listed_.push_back({std::move(*outcome.evaluated), at});
    }
  }
}

// The best `largest_count` by their true scores. Scores are upper bounds before: who is refined in
// their order can stop where the next bound is below what is kept.
void Planner::keep_best(Ledger* ledger) {
  std::sort(listed_.begin(), listed_.end(), better);
  const auto largest = static_cast<std::size_t>(options_.largest_count);
  std::size_t refined = 0;
  std::vector<double> kept;  // scores of the best so far, best first
  for (; refined < listed_.size(); ++refined) {
    Listed& listed = listed_[refined];
    if (kept.size() >= largest && kept[largest - 1] >= listed.grasp().score) break;
    evaluator_.refine(&listed.evaluated);
    assess_surface(&listed.evaluated);
    kept.insert(std::upper_bound(kept.begin(), kept.end(), listed.grasp().score, std::greater<>()),
                listed.grasp().score);
  }
  std::sort(listed_.begin(), listed_.begin() + static_cast<std::ptrdiff_t>(refined), better);
  for (std::size_t i = largest; i < listed_.size(); ++i) {
    ledger->reject(reason::kRankedBelow, listed_[i].grasp().generator);
  }
  if (listed_.size() > largest) listed_.resize(largest);
}

// Who is assessed no more counts as if nothing held.
void Planner::assess_robustness(const std::function<bool()>& time_is_up) {
  std::vector<GraspEvaluator> alternatives;
  for (const auto& mesh_W : object_.alternatives_W) {
    alternatives.emplace_back(make_solid(mesh_W, options_.density), table_, Obstacles{}, gripper_,
                              reachability_, options_);
  }
  const std::size_t samples = disturbances_.size();
  std::vector<std::optional<bool>> held(listed_.size() * samples);
  for_each_index(held.size(), options_.threads, [&](std::size_t i) {
    if (time_is_up()) return;
    const Grasp& grasp = listed_[i / samples].grasp();
    const std::size_t shape = i % samples % (alternatives.size() + 1);
    const GraspEvaluator& evaluator = shape == 0 ? evaluator_ : alternatives[shape - 1];
    const Disturbance& one = disturbances_[i % samples];
    held[i] = evaluator.holds(grasp, grasp.X_WG * one.X_GD, one.friction);
  });
  for (std::size_t g = 0; g < listed_.size(); ++g) {
    Grasp& grasp = listed_[g].grasp();
    grasp.robustness = share_held(held, g * samples, samples).value_or(grasp.robustness);
    grasp.score *= 1 - options_.weights.robust * (1 - std::max(0.0, grasp.robustness));
  }
}

// The one reason to tell: out of reach, too wide, or the last test that at least a tenth of the
// reachable candidates got to.
std::string Planner::problem(const GraspPlanResult& result, const Ledger& ledger) const {
  const std::string start = "cannot be grasped: ";
  const int reachable =
      result.candidates - ledger.count(reason::kDirection) - ledger.count(reason::kWorkspace);
  if (reachable == 0) return start + "no approach to it is within the robot's reach";
  if (std::isfinite(narrowest_) && narrowest_ > gripper_.max_opening + options_.width_tolerance -
                                                    2 * options_.collision.object_margin) {
    const auto [width, opening] = text::told_apart(narrowest_ * 1e3, gripper_.max_opening * 1e3, 0);
    return start + fmt::format("narrowest width {} mm exceeds the gripper's {} mm{}", width,
                               opening,
                               narrowest_ <= gripper_.max_opening ? " less the clearance" : "");
  }
  const char* last = reason::kNoTime;
  for (const char* stage : kStages) {
    if (stage != reason::kDirection && stage != reason::kWorkspace &&
        10 * ledger.count(stage) >= reachable) {
      last = stage;
    }
  }
  if (last == reason::kTooHeavy) {
    return start + fmt::format("too heavy for the grip force: {:.2f} kg need more than {:.0f} N",
                               evaluator_.solid().mass, evaluator_.largest_force());
  }
  return start +
         fmt::format("{} ({} of {} reachable candidates)", last, ledger.count(last), reachable);
}

GraspPlanResult Planner::plan() {
  const auto start = steady_clock::now();
  const auto time_is_up = [&] {
    return options_.budget > 0 &&
           std::chrono::duration<double>(steady_clock::now() - start).count() > options_.budget;
  };
  std::vector<Tried> tried;
  for (const Candidate& candidate : options_.given_W) tried.push_back({kGiven, candidate});
  const bool given = !tried.empty();
  if (!given) tried = candidates(options_.generators);
  GraspPlanResult result;
  result.candidates = static_cast<int>(tried.size());
  Ledger ledger;
  examine(tried, time_is_up, &ledger);
  if (!given && listed_.empty() && !time_is_up()) {
    const std::vector<Tried> further = candidates(options_.further_generators);
    result.candidates += static_cast<int>(further.size());
    examine(further, time_is_up, &ledger);
  }
  keep_best(&ledger);
  if (options_.uncertainty.samples > 0 && !listed_.empty()) {
    assess_robustness(time_is_up);
    std::sort(listed_.begin(), listed_.end(), better);
  }
  for (Listed& listed : listed_) {
    if (listed.grasp().robustness < 0) add_remark(kNotAssessed, &listed.grasp().remark);
    result.grasps.push_back(std::move(listed.grasp()));
  }
  result.rejections = ledger.rejections(kStages);
  if (result.grasps.empty()) result.problem = problem(result, ledger);
  return result;
}

}  // namespace

void PlannerOptions::validate() const {
  const text::Require require{"PlannerOptions."};
  require(!generators.empty(), "generators must name at least one generator");
  candidates.validate();
  closing.validate();
  require(cone_edges >= 3, "cone_edges must be at least 3");
  collision.validate();
  require(density > 0, "density must be positive");
  require(friction > 0, "friction must be positive");
  require(safety_factor >= 1, "safety_factor must be at least 1");
  require(lift_acceleration >= 0, "lift_acceleration must not be negative");
  require(least_force > 0, "least_force must be positive");
  require(largest_force >= 0, "largest_force must not be negative");
  require(pregrasp_distance > 0, "pregrasp_distance must be positive");
  require(opening_clearance >= 0, "opening_clearance must not be negative");
  require(width_tolerance >= 0, "width_tolerance must not be negative");
  require(largest_offset >= 0, "largest_offset must not be negative");
  require(largest_count > 0, "largest_count must be positive");
  require(budget >= 0, "budget must not be negative");
  require(threads >= 0, "threads must not be negative");
  const auto& w = weights;
  require(w.quality >= 0 && w.centredness >= 0 && w.area >= 0 && w.clearance >= 0 &&
              w.quality + w.centredness + w.area + w.clearance > 0,
          "weights must not be negative, nor all zero");
  require(w.guessed >= 0 && w.guessed <= 1, "weights.guessed must be within 0 and 1");
  require(w.robust >= 0 && w.robust <= 1, "weights.robust must be within 0 and 1");
  uncertainty.validate();
}

GraspPlanResult plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                            const Obstacles& obstacles, const robot::GripperModel& gripper,
                            const Reachability& reachability, const PlannerOptions& options) {
  options.validate();
  return Planner(object, table, obstacles, gripper, reachability, options).plan();
}

}  // namespace prehend::grasp
