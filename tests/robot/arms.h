#pragma once

#include <random>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::robot {

/// The arms of config/robots. Tests run in the project's folder.
inline KinematicChain kr5() {
  return KinematicChain(read_urdf("config/robots/kr5_sixx_r850.urdf"), "base_link", "tool0");
}
inline KinematicChain pa10() {
  return KinematicChain(read_urdf("config/robots/pa10_7c.urdf"), "base_link", "tool0");
}
inline KinematicChain stage() {
  return KinematicChain(read_urdf("config/robots/stage_pg70.urdf"), "base_link", "tool0");
}

inline double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

/// Within the limits.
inline Positions random_positions(const KinematicChain& chain, std::mt19937_64& random) {
  Positions q(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const ChainJoint& joint = chain.joints()[static_cast<std::size_t>(i)];
    q[i] = joint.lower + (joint.upper - joint.lower) * uniform(random);
  }
  return q;
}

/// Largest difference of two poses' numbers [m and 1].
inline double difference(const geometry::RigidTransform& a, const geometry::RigidTransform& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

}  // namespace prehend::robot
