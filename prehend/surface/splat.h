#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// Weights with which a point acts on the four nodes of an axis from `first` on. `smooth` are the
/// quadratic B-spline (three of them are not zero; they sum to 1). `slope` are the differences of
/// the B-spline on the middles between the nodes, so that a field splatted by it is the divergence
/// of one whose component along the axis was splatted there; they sum to 0.
struct SplineWindow {
  explicit SplineWindow(float x);  // coordinate in nodes, >= 0
  int first;
  Eigen::Array4f smooth;
  Eigen::Array4f slope;
};

/// The coordinates in the nodes of a grid with 2^level times the spacing that covers the same
/// space; node 0 of both has half a spacing to the border.
inline Eigen::Vector3f at_level(const Eigen::Vector3f& p, int level) {
  const float scale = 1.f / static_cast<float>(1 << level);
  return ((p.array() + 0.5f) * scale - 0.5f).matrix();
}

/// Adds `amount` at `p` [nodes], spread by the quadratic B-spline. @pre every node within 2 of `p`
/// is in the grid.
void splat(ScalarGrid& grid, const Eigen::Vector3f& p, float amount);

/// The grid's numbers about `p`, weighted by the quadratic B-spline.
float gather(const ScalarGrid& grid, const Eigen::Vector3f& p);

/// Adds the divergence of the vector `v` at `p`, spread by the quadratic B-spline.
void splat_divergence(ScalarGrid& grid, const Eigen::Vector3f& p, const Eigen::Vector3f& v);

/// Adds the numbers of `coarse`, of half the nodes along each axis, to `fine`, interpolated
/// linearly. @pre fine's sizes are twice coarse's.
void add_upsampled(const ScalarGrid& coarse, ScalarGrid& fine);

}  // namespace prehend::surface
