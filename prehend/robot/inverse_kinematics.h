#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "prehend/robot/branch_kernel.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::robot {

/// How a chain is inverted. Found out from its axes.
enum class InverseMethod {
  /// Closed form: six revolute axes, the last three through one point, the second and third
  /// parallel. All branches, at most 8. Pieper, "The kinematics of manipulators under computer
  /// control" (1968), by the subproblems of Paden (1986) on axes instead of Denavit-Hartenberg
  /// parameters; so shoulder and elbow offsets of any kind are exact.
  kSphericalWrist,
  /// Closed form for seven revolute axes with a spherical shoulder and a spherical wrist: the elbow
  /// is swept round the line from shoulder to wrist, at most 8 branches for each angle (Shimizu et
  /// al., "Analytical inverse kinematic computation for 7-DOF redundant manipulators with joint
  /// limits", IEEE T-RO 24(5), 2008).
  kSphericalShoulderAndWrist,
  /// Closed form for three prismatic axes that span space, behind or before a revolute one (stages,
  /// gantries): one solution, of poses that are turned about that axis alone.
  kThreeSlides,
  /// Damped least squares (Wampler 1986; damping after Levenberg and Marquardt) from the seed and
  /// random starts: one solution. Any chain.
  kNumeric,
};

struct InverseOptions {
  int elbow_angles = 16;    // kSphericalShoulderAndWrist: over the full turn, >= 1
  int restarts = 30;        // kNumeric, >= 0
  int iterations = 200;     // kNumeric, of each start, >= 1
  double tolerance = 1e-8;  // kNumeric: of position [m] and orientation [rad], > 0
  std::uint64_t seed = 1;   // kNumeric: of the random starts
  bool vectorized = true;   // kSphericalWrist: all branches in step; false: one by one
};

/// Why a pose has no solution.
enum class InverseFailure {
  kNone,
  kOutOfReach,    // for the chain without its limits
  kBeyondLimits,  // there are solutions that the limits forbid
  kNotFound,      // kNumeric: from no start
};

struct InverseAnswer {
  /// Within the limits; nearest to the seed first.
  std::vector<Positions> solutions;
  /// Why there are none, in words: out of reach, which limits, no convergence.
  std::string reason;
  InverseFailure failure = InverseFailure::kNone;
  /// How near it was: m by which the pose is out of reach (kThreeSlides: rad, by which it is
  /// tilted) or that the search is away from it, rad (or m, of a prismatic joint) by which the
  /// nearest solution is beyond a limit.
  double miss = 0;
  /// Two axes coincide at a solution: infinitely many are equivalent, and the joints' sum is shared
  /// out so that the first stays at the seed.
  bool singular = false;
};

/// The solutions of one of many poses, without memory of their own.
struct InverseSolutions {
  static constexpr int kMost = kBranches;

  int count = 0;
  std::array<Positions, kMost> q;                  // the first `count` of them, as in InverseAnswer
  InverseFailure failure = InverseFailure::kNone;  // when count is 0
  double miss = 0;
  bool singular = false;
};

/// Inverse kinematics of one chain. Reentrant: const calls may run at once. Same pose and seed,
/// same answer.
class InverseKinematics {
 public:
  /// @throws std::invalid_argument for a bad option.
  explicit InverseKinematics(KinematicChain chain, const InverseOptions& options = {});

  InverseMethod method() const { return method_; }
  const KinematicChain& chain() const { return chain_; }

  /// All solutions (kNumeric: one) for the tip at X_BT. A revolute joint's solution is turned by
  /// whole turns to be within its limits, as near to the seed as these allow. Without a seed it is
  /// the middle of the limits. @throws std::invalid_argument when the pose is not finite or the
  /// seed has another size.
  InverseAnswer solve(const geometry::RigidTransform& X_BT) const { return solve(X_BT, middle_); }
  InverseAnswer solve(const geometry::RigidTransform& X_BT,
                      const Eigen::Ref<const Eigen::VectorXd>& seed) const;
  /// The same for many poses at once: of each the solutions nearest to the seed, at most
  /// InverseSolutions::kMost. `answers` is resized; allocates nothing else for kSphericalWrist. Why
  /// a pose has none is told by solve(). @throws std::invalid_argument as solve().
  void solve_batch(std::span<const geometry::RigidTransform> X_BT,
                   const Eigen::Ref<const Eigen::VectorXd>& seed,
                   std::vector<InverseSolutions>& answers) const;

 private:
  struct Collector;
  void check(const geometry::RigidTransform& X_BT,
             const Eigen::Ref<const Eigen::VectorXd>& seed) const;
  void find(const geometry::RigidTransform& X_BT, Collector& found) const;
  /// By solve_branches(); false when that is not sure, or there are none.
  bool solve_in_step(const geometry::RigidTransform& X_BT,
                     const Eigen::Ref<const Eigen::VectorXd>& seed, BranchOutput& output) const;
  InverseMethod classify();
  /// Whether it is one of kThreeSlides.
  bool has_three_slides() const;
  void spherical_wrist(const geometry::RigidTransform& X_BT, Collector& found) const;
  void shoulder_and_wrist(const geometry::RigidTransform& X_BT, Collector& found) const;
  void three_slides(const geometry::RigidTransform& X_BT, Collector& found) const;
  void numeric(const geometry::RigidTransform& X_BT, Collector& found) const;

  KinematicChain chain_;
  InverseOptions options_;
  InverseMethod method_ = InverseMethod::kNumeric;
  Positions middle_;
  // At position 0, in the base frame.
  std::vector<Eigen::Vector3d> axis_, point_;  // of each joint
  Eigen::Vector3d shoulder_, wrist_;           // where axes meet [m]
  geometry::RigidTransform X_TB_;              // of the tip at position 0, inverse
  BranchArm branch_arm_;                       // kSphericalWrist
};

}  // namespace prehend::robot
