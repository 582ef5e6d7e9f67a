#include "nodes/grasp_cycle/view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "msgs/convert/cycle.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/outcomes.h"

namespace prehend::nodes {
namespace {

using grasp::PlanAnswer;
using grasp::PlanOutcome;

constexpr std::size_t kViewsKept = 4;
constexpr std::size_t kEmptyViewsKept = 256;
constexpr std::chrono::seconds kEmptyPatience{2};
constexpr double kLeastConfidence = 0.05;  // so that scores count among doubtful shapes too
constexpr double kMostOccluded = 0.25;  // of the outline, before an object counts as seen in part

// What a plan says of its object, for this robot.
PlanAnswer answer_for(const msgs::GraspPlan& plan, const Lacks& lacks) {
  PlanAnswer answer = convert::answer_of(plan);
  if (answer.outcome != PlanOutcome::kGraspable) return answer;
  const std::string lacking = lacks(plan.grasps(0));
  if (lacking.empty()) return answer;
  return {PlanOutcome::kFailed, "its grasps have " + lacking};  // another robot might
}

std::vector<const msgs::Grasp*> executable_grasps(const msgs::GraspPlan& plan, const Lacks& lacks) {
  std::vector<const msgs::Grasp*> grasps;
  for (const auto& grasp : plan.grasps()) {
    if (!lacks(grasp).empty()) break;  // indices are those of the plan
    grasps.push_back(&grasp);
  }
  return grasps;
}

// The best grasp's score, less for a prediction that is not sure or contradicts what was seen. What
// was only partly in view, and what comes last, come after everything else, by a negative value.
double promise(const View& view, const msgs::GraspPlan& plan, const OfObject& comes_last) {
  const double last = comes_last && comes_last(plan) ? 1 : 0;
  const double score = plan.grasps(0).score();
  const auto found = view.models.find(plan.id());
  if (found == view.models.end()) return score - last;
  const auto& model = *found->second;
  const double sure = std::clamp(model.confidence(), kLeastConfidence, 1.0);
  const double weighted = score * sure / (1 + std::max(0.0, model.vote()));
  const bool in_part = model.touches_image_border() || model.occluded_share() > kMostOccluded;
  return (in_part ? weighted - 1 : weighted) - last;
}

// "object 0: too wide; object 1: too heavy": the answer for all. Where an object could not be
// planned on, nobody knows whether it can be grasped: "no grasp: ...".
PlanAnswer answer_for_all(const View& view, const Lacks& lacks) {
  PlanAnswer all{PlanOutcome::kUngraspable, ""};
  for (const auto& [id, plan] : view.plans) {
    const PlanAnswer one = answer_for(*plan, lacks);
    if (one.outcome == PlanOutcome::kFailed) all.outcome = PlanOutcome::kFailed;
    all.problem +=
        (all.problem.empty() ? "" : "; ") + ("object " + std::to_string(id) + ": " + one.problem);
  }
  if (all.outcome == PlanOutcome::kFailed) all.problem = "no grasp: " + all.problem;
  return all;
}

}  // namespace

bool View::complete() const {
  if (plans.empty() || plans.size() < plans.begin()->second->object_count()) return false;
  return std::all_of(plans.begin(), plans.end(),
                     [this](const auto& entry) { return models.count(entry.first) > 0; });
}

View& ViewCollector::view_of(std::int64_t stamp) {
  View& view = views_[stamp];
  while (views_.size() > kViewsKept && views_.begin()->first != stamp) {
    views_.erase(views_.begin());
  }
  return view;
}

void ViewCollector::add(std::shared_ptr<const msgs::GraspPlan> plan,
                        std::chrono::steady_clock::time_point now) {
  View& view = view_of(plan->header().stamp());
  view.newest_plan = now;
  const std::uint32_t id = plan->id();
  view.plans[id] = std::move(plan);
}

void ViewCollector::add(std::shared_ptr<const msgs::ObjectModel> model) {
  View& view = view_of(model->header().stamp());
  const std::uint32_t id = model->id();
  view.models[id] = std::move(model);
}

void ViewCollector::add(const msgs::ObjectHypotheses& objects,
                        std::chrono::steady_clock::time_point now) {
  if (!objects.objects().empty()) return empty_views_.clear();
  why_nothing_ = objects.problem().empty() ? "no objects were found" : objects.problem();
  empty_views_.emplace(objects.header().stamp(), now);
  if (empty_views_.size() > kEmptyViewsKept) empty_views_.erase(empty_views_.begin());
}

std::string ViewCollector::why_nothing(std::chrono::steady_clock::time_point now,
                                       std::int64_t since) const {
  const auto first = empty_views_.lower_bound(since);
  const bool is_sure = first != empty_views_.end() && now - first->second >= kEmptyPatience;
  return is_sure ? why_nothing_ : "";
}

const View* ViewCollector::newest_ready(std::chrono::steady_clock::time_point now,
                                        std::int64_t since) const {
  for (auto entry = views_.rbegin(); entry != views_.rend() && entry->first >= since; ++entry) {
    const View& view = entry->second;
    if (view.plans.empty()) continue;
    if (view.complete() || now - view.newest_plan >= patience_) return &view;
  }
  return nullptr;
}

Target choose_target(const View& whole, int object, const Lacks& lacks, const OfObject& leaves_out,
                     const OfObject& comes_last) {
  Target target;
  View left = whole;
  if (object < 0 && leaves_out) {
    std::erase_if(left.plans, [&](const auto& entry) { return leaves_out(*entry.second); });
  }
  const View& view = left;
  if (view.plans.empty()) {
    target.problem = "none is left of " + std::to_string(whole.plans.size()) + " objects in view";
    target.none_left = true;
    return target;
  }
  const msgs::GraspPlan* best = nullptr;
  const auto can_be_grasped = [&lacks](const msgs::GraspPlan& plan) {
    return answer_for(plan, lacks).outcome == PlanOutcome::kGraspable;
  };
  if (object >= 0) {
    const auto found = view.plans.find(static_cast<std::uint32_t>(object));
    if (found == view.plans.end()) {
      target.problem = "there is no object " + std::to_string(object) + " among the " +
                       std::to_string(view.plans.size()) + " planned on";
      return target;
    }
    best = found->second.get();
  } else {
    for (const auto& [id, plan] : view.plans) {
      if (!can_be_grasped(*plan)) continue;
      if (!best || promise(view, *plan, comes_last) > promise(view, *best, comes_last)) {
        best = plan.get();
      }
    }
  }
  if (best && can_be_grasped(*best)) {
    target.id = best->id();
    target.outcome = PlanOutcome::kGraspable;
    target.grasps = executable_grasps(*best, lacks);
    return target;
  }
  if (!best && view.plans.size() == 1) best = view.plans.begin()->second.get();
  static_cast<PlanAnswer&>(target) = best ? answer_for(*best, lacks) : answer_for_all(view, lacks);
  target.id = best ? best->id() : view.plans.begin()->first;
  return target;
}

const msgs::GraspPlan* choose_push(const View& view, const OfObject& leaves_out) {
  const msgs::GraspPlan* best = nullptr;
  for (const auto& [id, plan] : view.plans) {
    if (!plan->has_push() || !convert::has_arm_motion(plan->push()) || leaves_out(*plan)) continue;
    if (!best || plan->push().score() > best->push().score()) best = plan.get();
  }
  return best;
}

bool met_too_early(std::span<const control::Surprise> of_attempt) {
  // On the way down to a place it is the weight that is predicted.
  return std::any_of(of_attempt.begin(), of_attempt.end(), [](const control::Surprise& one) {
    return one.kind == control::SurpriseKind::kTouchedTooEarly && one.surprising &&
           one.predicted == 0;
  });
}

int nearest_object(const View& view, const Eigen::Vector3d& p_W) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [id, plan] : view.plans) {
    const double distance = (convert::from_message(plan->centroid()) - p_W).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = static_cast<int>(id);
  }
  return nearest;
}

std::map<std::uint32_t, geometry::TriangleMesh> meshes_of(const View& view) {
  std::map<std::uint32_t, geometry::TriangleMesh> meshes;
  for (const auto& [id, model] : view.models) {
    if (model->valid()) meshes.emplace(id, convert::from_message(model->mesh()));
  }
  return meshes;
}

}  // namespace prehend::nodes
