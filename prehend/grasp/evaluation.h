#pragma once

#include <limits>
#include <optional>

#include "prehend/grasp/planner.h"
#include "prehend/grasp/solid.h"
#include "prehend/grasp/wrench_hull.h"

namespace prehend::grasp {

/// Every way a candidate can be rejected, in words for people.
namespace reason {
inline constexpr const char* kDirection = "approach direction out of the robot's reach";
inline constexpr const char* kWorkspace = "position outside the workspace";
inline constexpr const char* kArm = "out of the arm's reach";
inline constexpr const char* kNothing = "a pad would meet nothing";
inline constexpr const char* kTooWide = "wider than the gripper opens";
inline constexpr const char* kOffCentre = "section not centred between the fingers";
inline constexpr const char* kTable = "hand would hit the table";
inline constexpr const char* kObject = "open hand would hit the object";
inline constexpr const char* kObstacle = "hand would hit another object";
inline constexpr const char* kBottomsOut = "contact too small or sharp for the pads";
inline constexpr const char* kTurns = "closing would turn the object";
inline constexpr const char* kFinger = "a finger would touch beside its pad";
inline constexpr const char* kNotClosed = "no force closure";
inline constexpr const char* kTooHeavy = "too heavy for the grip force";
inline constexpr const char* kRankedBelow = "ranked below the best";
inline constexpr const char* kNoTime = "not tried: the time was used up";
}  // namespace reason

/// Why a candidate is no grasp.
struct Refusal {
  const char* reason = nullptr;
  std::optional<Miss> miss;
};

/// A candidate that is a grasp, with how the hand closes.
struct EvaluatedGrasp {
  Grasp grasp;
  ClosedHand hand;
  double clearance = 0;  // m, of the hand over the table
};

/// Closes the hand at candidates on one solid. The object of plan_grasps() is one, each of its
/// alternatives another. Const calls may run at once.
class GraspEvaluator {
 public:
  /// `options` are those of plan_grasps(), validated.
  GraspEvaluator(Solid solid, const geometry::Plane& table, const Obstacles& obstacles,
                 const robot::GripperModel& gripper, const Reachability& reachability,
                 const PlannerOptions& options);

  const Solid& solid() const { return solid_; }
  const geometry::MeshQuery& query() const { return query_; }
  double largest_force() const { return largest_force_; }  // N, per pad

  /// Fills `result` unless there is a reason not to. Quality and score are upper bounds until
  /// refine(): epsilon costs many times as much as everything else.
  std::optional<Refusal> evaluate(Candidate candidate, EvaluatedGrasp* result) const;
  /// Quality and score as they are.
  void refine(EvaluatedGrasp* evaluated) const;

  /// Whether the grasp, executed with the hand at `X_WG` instead, holds the solid with `friction`:
  /// meets nothing on its way, closes, and carries the weight.
  bool holds(const Grasp& grasp, const geometry::RigidTransform& X_WG, double friction) const;

 private:
  /// Turns the hand by half about its approach where the arm reaches it only so.
  std::optional<Refusal> reach(const Eigen::Vector3d& approach_W,
                               geometry::RigidTransform* X_WG) const;
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
  double score(const EvaluatedGrasp& evaluated) const;

  Solid solid_;
  geometry::MeshQuery query_;
  CollisionScene scene_;
  geometry::Plane table_;
  robot::GripperModel gripper_;  // opened by the width tolerance more than it can
  double largest_opening_ = 0;   // m, that it can
  Reachability reachability_;
  PlannerOptions options_;
  double largest_force_ = 0;  // N, per pad
};

}  // namespace prehend::grasp
