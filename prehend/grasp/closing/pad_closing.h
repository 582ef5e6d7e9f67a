#pragma once

#include <optional>
#include <string>

#include "prehend/grasp/closing/closing.h"
#include "prehend/grasp/wrench/wrench_hull.h"

namespace prehend::grasp {

/// Two parallel pads: the hand is centred on the section between them, closed on the mesh
/// (close_hand()), and kept when it reaches, does not collide, holds by soft-finger force closure
/// and carries the weight.
///
/// The grasp force follows from the mass m = volume * density (the hull's volume when the mesh is
/// not watertight): F = safety_factor * m (g + a) / (2 friction), raised where the centre of mass
/// is beside the pads' line so that the torque of the weight stays inside the elliptic limit
/// surface too, within [least_force, largest_force].
class PadClosing : public Closing {
 public:
  /// @pre the hand's `gripper` is set
  explicit PadClosing(const ClosingTask& task);

  HandReach reach(const robot::Preshape& preshape) const override;
  std::optional<Refusal> evaluate(const Candidate& candidate, const robot::Preshape& preshape,
                                  ClosedGrasp* closed) const override;
  std::optional<Refusal> refine(ClosedGrasp* closed) const override;
  bool bounds_score() const override { return true; }
  /// A parallel gripper's candidates stay where they are made.
  bool same(const Grasp& /*a*/, const Grasp& /*b*/) const override { return false; }
  bool holds(const Grasp& grasp, const geometry::RigidTransform& X_WG,
             double friction) const override;
  Eigen::VectorXd stops(const Grasp& grasp) const override;
  std::span<const Reason> stages() const override;
  std::string too_wide(double narrowest) const override;
  std::string explain(Reason reason) const override;

 private:
  struct Kept;
  /// Turns the hand by half about its approach where the arm reaches it only so.
  std::optional<Refusal> reach_pose(const Eigen::Vector3d& approach_W,
                                    const geometry::RigidTransform& X_GH,
                                    geometry::RigidTransform* X_WG) const;
  std::optional<Refusal> meets_table_anyway(const geometry::RigidTransform& X_WG) const;
  std::optional<Refusal> centre(geometry::RigidTransform* X_WG, double* section_width,
                                SectionExtent* section) const;
  std::optional<Refusal> find_opening(const geometry::RigidTransform& X_WG, double section_width,
                                      double* opening) const;
  std::optional<Refusal> close(const geometry::RigidTransform& X_WG, double opening,
                               const SectionExtent& section, ClosedHand* hand, double* force,
                               double* quality) const;
  Wrenches wrenches_of(const ClosedHand& hand, const geometry::RigidTransform& X_WG,
                       double friction) const;
  double room() const;  // m, widest section that fits between the open fingers
  double least_force() const;
  double load_ratio(const ClosedHand& hand, const geometry::RigidTransform& X_WG, double force,
                    double friction) const;
  double score(const Grasp& grasp, const Kept& kept) const;

  const Solid& solid_;
  const geometry::SurfaceQuery& query_W_;
  CollisionScene scene_;
  geometry::Plane table_;
  const robot::HandModel& hand_;
  robot::GripperModel gripper_;  // opened by the width tolerance more than it can
  double largest_opening_ = 0;   // m, that it can
  Reachability reachability_;
  const PlannerOptions& options_;
  double nominal_force_ = 0;  // N, per pad, of the gripper's nominal current
  double largest_force_ = 0;  // N, per pad
};

}  // namespace prehend::grasp
