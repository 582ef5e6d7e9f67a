#include "prehend/grasp/grasp_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;

constexpr double kSamePosition = 0.005;  // m
constexpr double kSameAngle = 0.1;       // rad

double angle_between(const RigidTransform& a, const RigidTransform& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

bool same(const RigidTransform& a, const RigidTransform& b) {
  return (a.translation() - b.translation()).norm() <= kSamePosition &&
         angle_between(a, b) <= kSameAngle;
}

// As GraspDatabase::record_execution looks for it.
const StoredGrasp& nearest(const std::vector<StoredGrasp>& stored, const RigidTransform& X_OG) {
  const auto key = [&X_OG](const StoredGrasp& grasp) {
    return std::pair((grasp.X_OG.translation() - X_OG.translation()).norm(),
                     angle_between(grasp.X_OG, X_OG));
  };
  return *std::min_element(stored.begin(), stored.end(),
                           [&](const auto& a, const auto& b) { return key(a) < key(b); });
}

Candidate candidate_at(const RigidTransform& X_WG) {
  Candidate candidate;
  candidate.X_WG = X_WG;
  candidate.approach_W = X_WG.linear().col(2);
  return candidate;
}

StoredGrasp stored(const Grasp& grasp, const RigidTransform& X_OW) {
  StoredGrasp result;
  result.X_OG = X_OW * grasp.X_WG;
  result.joints = {grasp.pregrasp_opening};
  result.force = grasp.grasp_force;
  result.quality = grasp.quality;
  result.score = grasp.score;
  return result;
}

StoredGrasp stored(const HandGrasp& grasp, const RigidTransform& X_OW) {
  StoredGrasp result;
  result.X_OG = X_OW * grasp.X_WG;
  result.joints.assign(grasp.open.begin(), grasp.open.end());
  result.quality = grasp.quality;
  result.score = grasp.score;
  return result;
}

// `plan` plans with the stored grasps as the only candidates, or without any: with all of them.
template <class Plan, class PlanFunction>
Plan plan_with_memory(GraspDatabase& database, const std::string& hand, const PlacedObject& placed,
                      const PlanFunction& plan, Remembered* remembered) {
  const std::vector<StoredGrasp> known = database.grasps(hand, placed.hash);
  const RigidTransform X_OW = placed.X_WO.inverse();
  if (remembered) *remembered = {static_cast<int>(known.size()), false};
  if (!known.empty()) {
    Plan again = plan(known);
    if (!again.grasps.empty()) {
      for (auto& grasp : again.grasps) {
        const StoredGrasp& source = nearest(known, X_OW * grasp.X_WG);
        grasp.score *= (source.successes + 1.0) / (source.attempts + 1.0);
      }
      std::stable_sort(again.grasps.begin(), again.grasps.end(),
                       [](const auto& a, const auto& b) { return a.score > b.score; });
      if (remembered) remembered->reused = true;
      return again;
    }
  }
  Plan fresh = plan({});
  std::vector<StoredGrasp> added;
  for (const auto& grasp : fresh.grasps) {
    StoredGrasp one = stored(grasp, X_OW);
    if (std::none_of(known.begin(), known.end(),
                     [&one](const auto& k) { return same(k.X_OG, one.X_OG); })) {
      added.push_back(std::move(one));
    }
  }
  if (!added.empty()) database.add(hand, placed.hash, placed.name, added);
  return fresh;
}

}  // namespace

GraspPlanResult plan_grasps_with_memory(GraspDatabase& database, const PlacedObject& placed,
                                        const surface::ObjectModel& object,
                                        const geometry::Plane& table, const Obstacles& obstacles,
                                        const robot::GripperModel& gripper,
                                        const Reachability& reachability,
                                        const PlannerOptions& options, Remembered* remembered) {
  const auto plan = [&](const std::vector<StoredGrasp>& known) {
    PlannerOptions with = options;
    for (const StoredGrasp& grasp : known) {
      with.given_W.push_back(candidate_at(placed.X_WO * grasp.X_OG));
    }
    return plan_grasps(object, table, obstacles, gripper, reachability, with);
  };
  return plan_with_memory<GraspPlanResult>(database, gripper.name, placed, plan, remembered);
}

HandPlan plan_hand_grasps_with_memory(GraspDatabase& database, const PlacedObject& placed,
                                      const surface::ObjectModel& object,
                                      const geometry::Plane& table, const Obstacles& obstacles,
                                      const HandToClose& hand, const Reachability& reachability,
                                      const HandPlannerOptions& options, Remembered* remembered) {
  const auto plan = [&](const std::vector<StoredGrasp>& known) {
    HandPlannerOptions with = options;
    for (const StoredGrasp& grasp : known) {
      const Eigen::Map<const Eigen::VectorXd> open(grasp.joints.data(),
                                                   static_cast<Eigen::Index>(grasp.joints.size()));
      for (const robot::Preshape& preshape : hand.hand->preshapes) {
        if (preshape.open.size() != open.size() || !((preshape.open - open).norm() < 1e-6)) {
          continue;
        }
        with.given_W.push_back({preshape.name, candidate_at(placed.X_WO * grasp.X_OG)});
        break;
      }
    }
    if (!known.empty() && with.given_W.empty()) return HandPlan{};
    return plan_hand_grasps(object, table, obstacles, hand, reachability, with);
  };
  return plan_with_memory<HandPlan>(database, hand.hand->name, placed, plan, remembered);
}

bool remember_execution(GraspDatabase& database, const PlacedObject& placed,
                        const std::string& hand, const RigidTransform& X_WG, bool held) {
  return database.record_execution(hand, placed.hash, placed.X_WO.inverse() * X_WG, held);
}

}  // namespace prehend::grasp
