#include "nodes/grasp_cycle/view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "prehend/geometry/rotation_between.h"

namespace prehend::nodes {
namespace {

constexpr std::size_t kViewsKept = 4;
constexpr double kLeastConfidence = 0.05;  // so that scores count among doubtful shapes too
constexpr double kMostOccluded = 0.25;  // of the outline, before an object counts as seen in part
constexpr const char* kUngraspable = "cannot be grasped";

bool says_ungraspable(const msgs::GraspPlan& plan) {
  return plan.problem().rfind(kUngraspable, 0) == 0;
}

std::vector<grasp::Grasp> grasps_of(const msgs::GraspPlan& plan) {
  std::vector<grasp::Grasp> grasps;
  for (const auto& grasp : plan.grasps()) grasps.push_back(convert::from_message(grasp));
  return grasps;
}

// The best grasp's score, less for a prediction that is not sure or contradicts what was seen. What
// was only partly in view comes after everything else, by a negative value.
double promise(const View& view, const msgs::GraspPlan& plan) {
  const double score = plan.grasps(0).score();
  const auto found = view.models.find(plan.id());
  if (found == view.models.end()) return score;
  const auto& model = *found->second;
  const double sure = std::clamp(model.confidence(), kLeastConfidence, 1.0);
  const double weighted = score * sure / (1 + std::max(0.0, model.vote()));
  const bool in_part = model.touches_image_border() || model.occluded_share() > kMostOccluded;
  return in_part ? weighted - 1 : weighted;
}

// "cannot be grasped: object 0: too wide; object 1: too heavy". Where an object could not be
// planned on, nobody knows whether it can be grasped: "no grasp: ...".
std::string all_problems(const View& view, bool ungraspable) {
  const std::string start = std::string(kUngraspable) + ": ";
  std::string text;
  for (const auto& [id, plan] : view.plans) {
    std::string problem = plan->problem();
    if (problem.rfind(start, 0) == 0) problem.erase(0, start.size());
    text += (text.empty() ? "" : "; ") + ("object " + std::to_string(id) + ": " + problem);
  }
  return (ungraspable ? start : "no grasp: ") + text;
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

const View* ViewCollector::newest_ready(std::chrono::steady_clock::time_point now,
                                        std::int64_t since) const {
  for (auto entry = views_.rbegin(); entry != views_.rend() && entry->first >= since; ++entry) {
    const View& view = entry->second;
    if (view.plans.empty()) continue;
    if (view.complete() || now - view.newest_plan >= patience_) return &view;
  }
  return nullptr;
}

Target choose_target(const View& view, int object) {
  Target target;
  const msgs::GraspPlan* best = nullptr;
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
      if (plan->grasps().empty()) continue;
      if (!best || promise(view, *plan) > promise(view, *best)) best = plan.get();
    }
  }
  if (best && !best->grasps().empty()) {
    target.id = best->id();
    target.grasps = grasps_of(*best);
    return target;
  }
  if (!best && view.plans.size() == 1) best = view.plans.begin()->second.get();
  target.ungraspable = best ? says_ungraspable(*best)
                            : std::all_of(view.plans.begin(), view.plans.end(), [](const auto& e) {
                                return says_ungraspable(*e.second);
                              });
  target.problem = best ? best->problem() : all_problems(view, target.ungraspable);
  target.id = best ? best->id() : view.plans.begin()->first;
  return target;
}

std::map<std::uint32_t, geometry::TriangleMesh> meshes_of(const View& view) {
  std::map<std::uint32_t, geometry::TriangleMesh> meshes;
  for (const auto& [id, model] : view.models) {
    if (model->valid()) meshes.emplace(id, convert::from_message(model->mesh()));
  }
  return meshes;
}

geometry::RigidTransform simulation_pose(const View& view, const Target& target) {
  const auto& model = *view.models.at(target.id);
  const geometry::Plane table = convert::from_message(model.table());
  const Eigen::Vector3d up = -target.grasps.front().approach_W;
  const Eigen::Vector3d foot = table.project(convert::from_message(model.centroid()));
  geometry::RigidTransform X_SW = geometry::RigidTransform::Identity();
  const bool stands_well = (up - Eigen::Vector3d::UnitZ()).norm() < 1e-6 &&
                           std::abs(foot.z()) < 0.005 && foot.head<2>().norm() < 0.4;
  if (stands_well) return X_SW;
  X_SW.linear() = geometry::rotation_between(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  X_SW.translation() = -(X_SW.linear() * foot);
  return X_SW;
}

grasp::Grasp transformed(const grasp::Grasp& grasp_W, const geometry::RigidTransform& X_SW) {
  grasp::Grasp grasp = grasp_W;
  grasp.X_WG = X_SW * grasp_W.X_WG;
  grasp.approach_W = X_SW.linear() * grasp_W.approach_W;
  for (auto* contacts : {&grasp.left_contacts_W, &grasp.right_contacts_W}) {
    for (auto& p : *contacts) p = X_SW * p;
  }
  return grasp;
}

}  // namespace prehend::nodes
