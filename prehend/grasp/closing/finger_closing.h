#pragma once

#include <optional>

#include "prehend/grasp/closing/closing.h"
#include "prehend/grasp/closing/distance_grid.h"
#include "prehend/grasp/wrench/force_limits.h"

namespace prehend::grasp {

/// Fingers: the open hand moves along the approach until it touches or is at its standoff, and its
/// fingers close on the mesh (close_fingers()). Kept is what the arm reaches, what meets nothing on
/// the way, what enough fingers touch without the table or each other in between, what is
/// force-closed with soft fingers (wrench_hull()), and what the motors can hold against gravity and
/// the lift's acceleration with the safety factor (hold()).
class FingerClosing : public Closing {
 public:
  explicit FingerClosing(const ClosingTask& task);

  HandReach reach(const robot::Preshape& preshape) const override;
  /// The quality is a lower bound within 5 %; margin, effort and volume are left out.
  std::optional<Refusal> evaluate(const Candidate& candidate, const robot::Preshape& preshape,
                                  ClosedGrasp* closed) const override;
  std::optional<Refusal> refine(ClosedGrasp* closed) const override;
  bool bounds_score() const override { return false; }
  /// Different standoffs that the same contact ends are one grasp, and so are preshapes that close
  /// to the same.
  bool same(const Grasp& a, const Grasp& b) const override;
  bool holds(const Grasp& grasp, const geometry::RigidTransform& X_WG,
             double friction) const override;
  Eigen::VectorXd stops(const Grasp& grasp) const override;
  std::span<const Reason> stages() const override;

 private:
  std::optional<Refusal> close(const robot::Preshape& preshape, Touched stopped_by, Grasp* grasp,
                               Wrenches* wrenches, double friction = 0) const;  // 0: the hand's
  HandForces forces(const Grasp& grasp) const;
  Vector6 load() const;  // the weight while it is lifted
  std::optional<Refusal> approach(const robot::Preshape& preshape, Grasp* grasp,
                                  Advance* advance) const;
  bool fingers_meet(const Grasp& grasp) const;
  double score(const Grasp& grasp) const;

  const Solid& solid_;
  DistanceGrid grid_;
  std::optional<geometry::MeshQuery> obstacle_query_;
  std::optional<DistanceGrid> obstacle_grid_;
  geometry::Plane table_;
  const HandToClose& hand_;
  Reachability reachability_;
  const PlannerOptions& options_;
};

/// What a generator must know of a hand in a preshape: how far its fingertips reach while they
/// close, its pads' length, how far its fingers are apart when open.
HandReach hand_reach(const HandToClose& hand, const robot::Preshape& preshape);

}  // namespace prehend::grasp
