#pragma once

#include <random>
#include <vector>

#include "prehend/contact/pad_kernel.h"
#include "prehend/geometry/triangle_mesh.h"

/// Pads and states that tests share.
namespace prehend::contact::testing {

/// A fingertip: the upper half of a ball of 10 mm, 2 mm of foam.
inline PadLayout fingertip() {
  geometry::TriangleMesh ball = geometry::make_sphere(0.01, 16);
  std::erase_if(ball.triangles, [&](const Eigen::Vector3i& t) {
    return ball.vertices[t[0]].z() + ball.vertices[t[1]].z() + ball.vertices[t[2]].z() < 0;
  });
  return PadLayout::curved(ball, 0.002);
}

/// Depths between a small gap and the thickness, bristles of up to 0.4 mm.
inline PadState random_state(const PadLayout& pad, std::mt19937& random) {
  std::uniform_real_distribution<double> depth(-2e-4, pad.thickness()), bristle(-4e-4, 4e-4);
  PadState state(pad);
  for (std::size_t i = 0; i < pad.size(); ++i) {
    state.depth[i] = depth(random);
    state.bristle_u[i] = bristle(random);
    state.bristle_v[i] = bristle(random);
  }
  return state;
}

inline Vector6 random_twist(std::mt19937& random, double speed = 0.05) {
  std::uniform_real_distribution<double> value(-speed, speed);
  Vector6 twist;
  for (int i = 0; i < 6; ++i) twist[i] = (i < 3 ? 1 : 30) * value(random);
  return twist;
}

}  // namespace prehend::contact::testing
