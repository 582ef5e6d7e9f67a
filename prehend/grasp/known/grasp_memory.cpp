#include "prehend/grasp/known/grasp_memory.h"

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

StoredGrasp stored(const robot::HandModel& hand, const Grasp& grasp, const RigidTransform& X_OW) {
  StoredGrasp result;
  result.X_OG = X_OW * grasp.X_WG;
  result.joints.assign(grasp.open.begin(), grasp.open.end());
  if (hand.gripper) result.joints = {pregrasp_opening(grasp)};
  result.force = grasp.force;
  result.quality = grasp.quality;
  result.score = grasp.score;
  return result;
}

// Which preshape a stored grasp is of; null: of none.
const robot::Preshape* preshape_of(const robot::HandModel& hand, const StoredGrasp& grasp) {
  if (hand.gripper) return &hand.preshapes.front();
  const Eigen::Map<const Eigen::VectorXd> open(grasp.joints.data(),
                                               static_cast<Eigen::Index>(grasp.joints.size()));
  for (const robot::Preshape& preshape : hand.preshapes) {
    if (preshape.open.size() == open.size() && (preshape.open - open).norm() < 1e-6) {
      return &preshape;
    }
  }
  return nullptr;
}

}  // namespace

const std::string& remembered_as(const robot::HandModel& hand) {
  return hand.gripper ? hand.gripper->name : hand.name;
}

GraspPlan plan_grasps_with_memory(GraspDatabase& database, const PlacedObject& placed,
                                  const surface::ObjectModel& object, const geometry::Plane& table,
                                  const Obstacles& obstacles, const HandToClose& hand,
                                  const Reachability& reachability, const PlannerOptions& options,
                                  Remembered* remembered) {
  const robot::HandModel& model = *hand.hand;
  const std::vector<StoredGrasp> known = database.grasps(remembered_as(model), placed.hash);
  const RigidTransform X_OW = placed.X_WO.inverse();
  if (remembered) *remembered = {static_cast<int>(known.size()), false};
  PlannerOptions with_known = options;
  for (const StoredGrasp& grasp : known) {
    if (const robot::Preshape* preshape = preshape_of(model, grasp)) {
      with_known.given_W.push_back({candidate_at(placed.X_WO * grasp.X_OG), preshape->name});
    }
  }
  if (with_known.given_W.size() > options.given_W.size()) {
    GraspPlan again = plan_grasps(object, table, obstacles, hand, reachability, with_known);
    if (!again.grasps.empty()) {
      for (Grasp& grasp : again.grasps) {
        const StoredGrasp& source = nearest(known, X_OW * grasp.X_WG);
        grasp.score *= (source.successes + 1.0) / (source.attempts + 1.0);
      }
      std::stable_sort(again.grasps.begin(), again.grasps.end(),
                       [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
      if (remembered) remembered->reused = true;
      return again;
    }
  }
  GraspPlan fresh = plan_grasps(object, table, obstacles, hand, reachability, options);
  std::vector<StoredGrasp> added;
  for (const Grasp& grasp : fresh.grasps) {
    StoredGrasp one = stored(model, grasp, X_OW);
    if (std::none_of(known.begin(), known.end(),
                     [&one](const auto& k) { return same(k.X_OG, one.X_OG); })) {
      added.push_back(std::move(one));
    }
  }
  if (!added.empty()) database.add(remembered_as(model), placed.hash, placed.name, added);
  return fresh;
}

bool remember_execution(GraspDatabase& database, const PlacedObject& placed,
                        const std::string& hand, const RigidTransform& X_WG, bool held) {
  return database.record_execution(hand, placed.hash, placed.X_WO.inverse() * X_WG, held);
}

}  // namespace prehend::grasp
