#pragma once

#include <memory>
#include <optional>

#include "prehend/grasp/evaluation.h"
#include "prehend/grasp/force_limits.h"
#include "prehend/grasp/hand_planner.h"
#include "prehend/grasp/solid.h"

namespace prehend::grasp {

/// Every way a hand's candidate can be rejected that evaluation.h does not name.
namespace reason {
inline constexpr const char* kFewFingers = "too few fingers would touch the object";
inline constexpr const char* kFingerTable = "a finger would touch the table as it closes";
inline constexpr const char* kFingerObstacle = "a finger would touch another object as it closes";
inline constexpr const char* kFingersMeet = "fingers would touch each other";
inline constexpr const char* kSame = "the same as a better one";
inline constexpr const char* kTooWeak = "the motors cannot hold the load";
}  // namespace reason

/// Closes a hand at candidates on one solid. Const calls may run at once.
class HandEvaluator {
 public:
  /// `options` are those of plan_hand_grasps(), validated.
  HandEvaluator(Solid solid, const geometry::Plane& table, const Obstacles& obstacles,
                const HandToClose& hand, const Reachability& reachability,
                const HandPlannerOptions& options);

  const Solid& solid() const { return solid_; }
  const geometry::MeshQuery& query() const { return query_; }

  /// Fills `grasp` unless there is a reason not to; its quality is a lower bound within 5 %, and
  /// margin, effort, volume and score are left out.
  std::optional<Refusal> evaluate(const Candidate& candidate, const robot::Preshape& preshape,
                                  HandGrasp* grasp) const;
  /// What the motors must do, and how well they do it: fills effort, torques, margin and volume,
  /// and makes the quality exact.
  std::optional<Refusal> assess_forces(HandGrasp* grasp) const;
  double score(const HandGrasp& grasp) const;

  /// Whether the grasp, executed with the hand's root at `X_WH` instead, holds the solid with
  /// `friction`: the open hand meets nothing on its way, enough fingers close on the object alone,
  /// and the motors carry the weight.
  bool holds(const HandGrasp& grasp, const geometry::RigidTransform& X_WH, double friction) const;

 private:
  std::optional<Refusal> close(const robot::Preshape& preshape, Touched stopped_by,
                               HandGrasp* grasp, Wrenches* wrenches,
                               double friction = 0) const;  // 0: the hand's
  HandForces forces(const HandGrasp& grasp) const;
  Vector6 load() const;  // the weight while it is lifted
  std::optional<Refusal> approach(const robot::Preshape& preshape, HandGrasp* grasp,
                                  Advance* advance) const;
  bool fingers_meet(const HandGrasp& grasp) const;

  Solid solid_;
  geometry::MeshQuery query_;
  DistanceGrid grid_;
  std::optional<geometry::MeshQuery> obstacle_query_;
  std::optional<DistanceGrid> obstacle_grid_;
  geometry::Plane table_;
  const HandToClose& hand_;
  Reachability reachability_;
  const HandPlannerOptions& options_;
};

}  // namespace prehend::grasp
