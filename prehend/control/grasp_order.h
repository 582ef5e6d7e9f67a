#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::control {

/// Where a hand is when it closes.
struct GraspPose {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();
  std::string preshape;  // of a hand with fingers; empty: a parallel gripper
};

/// The hand is where it was with the other grasp: within 6 mm and 0.15 rad, in the same preshape. A
/// parallel gripper turned by half about its approach is the same.
bool is_like(const GraspPose& a, const GraspPose& b);

/// Which grasp of a plan is the next: none twice, and those like one that failed, in this plan or
/// one before, last, as they would fail again where nothing has moved.
class GraspOrder {
 public:
  /// Forgets what failed; the plan has these grasps.
  void start(std::vector<GraspPose> grasps);
  /// A new plan, of the same object.
  void take(std::vector<GraspPose> grasps);

  /// It is the next one, until it was tried. @throws std::out_of_range for none of the plan.
  void prefer(int grasp);

  /// The first that was not tried and is like none that failed; else the first that was not tried;
  /// none when all were.
  std::optional<int> next() const;
  /// It is tried now.
  void begin(int grasp);
  /// It was not tried after all. @pre begin() was called with it
  void put_back(int grasp);
  /// It failed. @pre begin() was called with it
  void fail(int grasp);

 private:
  std::vector<GraspPose> grasps_;
  std::vector<bool> tried_;        // of grasps_
  std::optional<int> preferred_;   // of grasps_
  std::vector<GraspPose> failed_;  // of all plans
};

}  // namespace prehend::control
