#pragma once

#include <vector>

#include <Eigen/Core>

// How far two runs of one scene are apart in what pads feel and in where the object is.
namespace prehend::eval::touch {

/// What a pad's texels feel at one instant, row by row; the texels divide the pad evenly.
struct PadFrame {
  int rows = 0, columns = 0;
  std::vector<double> force;  // N, rows * columns

  double sum() const;  // N
};

/// Integral of |p_a - p_b| over the pad's face [N], p being each texel's force over its area. Of
/// equal grids the sum of |a_i - b_i|; other grids are compared where their texels overlap, without
/// interpolation. Never less than |a.sum() - b.sum()|. Both are of one face, whatever its size.
/// @throws std::invalid_argument when a frame has not rows * columns forces, or no texel.
double image_distance(const PadFrame& a, const PadFrame& b);

/// What is to be compared of a run.
struct FeltRun {
  std::vector<std::vector<PadFrame>> frames;  // of each instant, each pad; empty: nothing feels
  std::vector<Eigen::Vector3d> path;          // m, of the object, at these instants
};

/// Of what is felt relative to the reference's largest sum of a pad at any instant; of instants and
/// pads those count where either run feels something.
struct FeltError {
  double image = 0;    // root mean square of image_distance
  double sum = 0;      // root mean square of the sums' differences, at most `image`
  double largest = 0;  // image_distance at most: a touch that begins a step late shows here
  double motion = 0;   // m, largest distance of the object

  bool is_finite() const;
};

/// @throws std::invalid_argument when the runs have not the same instants and pads, or the
/// reference's pads feel nothing.
FeltError felt_error(const FeltRun& run, const FeltRun& reference);

/// The worse of both in each: of several scenes.
FeltError worst(const FeltError& a, const FeltError& b);

}  // namespace prehend::eval::touch
