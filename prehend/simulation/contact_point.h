#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/texel.h"

namespace prehend::simulation {

/// What an object's point touches. Codes from kOtherBody on are kOtherBody + id of the other body.
enum ContactPartner : std::uint32_t {
  kTable = 0,
  kLeftFinger,
  kRightFinger,
  kHousing,
  kLeftPad,   // a rigid one; pads with texels are no points
  kRightPad,  //
  kOtherBody = 16
};

/// One touching point of body `a` and its partner for one step. World frame.
struct ContactPoint {
  std::uint64_t key = 0;  // names point and partner; the bristle is kept under it
  std::uint32_t partner = kTable;
  int a = -1;  // index of the touched body
  int b = -1;  // index of the other body, or -1
  const contact::TexelLaw* law = nullptr;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, from the partner into body a
  double depth = 0;  // m, negative: a gap that may close within the step
  /// Velocity of the partner's point without what is solved for [m/s]: that of the carrier.
  Eigen::Vector3d partner_velocity = Eigen::Vector3d::Zero();
  /// The partner's point also moves with slide_motion * (velocity of the gripper's slide).
  Eigen::Vector3d slide_motion = Eigen::Vector3d::Zero();

  Eigen::Vector3d bristle = Eigen::Vector3d::Zero();  // m, tangential; updated by the solver
  // Results of the solver.
  double normal_force = 0;                          // N
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, on body a
};

inline std::uint64_t contact_key(std::uint32_t body_id, std::uint32_t partner,
                                 std::uint32_t point) {
  return static_cast<std::uint64_t>(body_id) << 40 | static_cast<std::uint64_t>(partner) << 20 |
         point;
}

/// A bristle between two steps, in the world frame or, on the gripper, in the gripper frame.
struct StoredBristle {
  std::uint64_t key = 0;
  Eigen::Vector3d bristle = Eigen::Vector3d::Zero();

  template <class Archive>
  void archive(Archive& archive) {
    archive(key, bristle);
  }
};

}  // namespace prehend::simulation
