#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// A place where the field should have a value.
struct ScreenedPoint {
  Eigen::Vector3f position;  // [nodes]
  float weight;              // > 0
};

struct ScreeningOptions {
  int iterations = 3;  // of conjugate gradients, >= 0
  int reach = 2;       // nodes about the points' cells that move, 1..8
};

/// Moves `field`, a minimum u of ∫ |∇u - V|² (a solution of L u = div V), in a band about `points`
/// towards the minimum of
///
///     ∫ |∇u - V|² + Σ_i weight_i (u(p_i) - level)²
///
/// (Kazhdan and Hoppe, "Screened Poisson Surface Reconstruction", ACM Transactions on Graphics
/// 2013, equation 3), spacing 1, u interpolated linearly between the nodes, by conjugate gradients
/// with the diagonal as preconditioner. V itself is not needed: the first residual of a solution is
/// that of the points alone. What is far from the points keeps its value.
/// O(iterations (band + points)). @pre the points lie between nodes 2 and size - 3.
void screen(ScalarGrid& field, const std::vector<ScreenedPoint>& points, float level,
            const ScreeningOptions& options);

/// `field` at `p` [nodes], interpolated linearly. @pre the eight nodes about `p` are in the grid.
float interpolated(const ScalarGrid& field, const Eigen::Vector3f& p);

}  // namespace prehend::surface
