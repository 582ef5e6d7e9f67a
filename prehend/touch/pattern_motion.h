#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_layout.h"
#include "prehend/touch/felt_pad.h"

namespace prehend::touch {

/// Normal equations of how the pattern of pressure moved between two frames p0 and p1 of a flat
/// pad: shift t and turn w about the pattern's centre, relative change g of the force,
///   p1 - p0 = -grad p . (t + w z x r) + g p,   p, grad p of the frames' mean
/// for each texel near the touched ones (B. Lucas and T. Kanade, "An Iterative Image Registration
/// Technique", 1981, one step). It holds for motions up to about a texel. Lengths are in texels'
/// distances; the unknowns are t.x, t.y, w, g.
struct PatternEquations {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // m, of the mean pattern's pressure
  double mean_square = 0;                            // N^2, of the mean pattern's texels
  std::vector<std::pair<Eigen::Vector4d, double>> rows;

  /// Root mean square of what is left over [N] when the unknowns are x; 0 for too few equations.
  double left_over(const Eigen::Vector4d& x) const;
};

/// Knows a pad's neighbours, which all its frames share.
class PatternMotion {
 public:
  explicit PatternMotion(const contact::PadLayout& layout);

  double distance() const { return distance_; }  // m, between texels
  /// @param ignored texels that say nothing of the pattern (as dead ones); empty: none. Texels that
  /// are full or unreadable in either frame, and the neighbours of all of these, are left out.
  /// @pre the layout is flat, both frames are of it and one of them is touched
  PatternEquations between(const FeltTexels& then, const FeltTexels& now,
                           const std::vector<bool>& ignored = {}) const;

 private:
  /// Value and gradient (per texels' distance) at a texel: sum of weight times the values there.
  using Stencil = std::vector<std::pair<std::size_t, Eigen::Vector3d>>;

  std::vector<Eigen::Vector2d> places_;  // m
  double distance_ = 0;
  std::vector<Stencil> stencils_;  // empty at the pad's border
};

}  // namespace prehend::touch
