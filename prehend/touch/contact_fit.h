#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/felt_pad.h"

namespace prehend::touch {

struct FittedNormal {
  Eigen::Vector3d direction =
      Eigen::Vector3d::UnitZ();  // unit, out of the pad into what it touches
  double deviation = 0;          // rad, standard, of its direction
};

/// Of the touched surface, positive where it bulges into the pad: 1/R twice for a ball of radius R.
struct FittedCurvature {
  double largest = 0, smallest = 0;                      // 1/m, principal, `largest` first
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit, along which it is `largest`
  double deviation = 0;                                  // 1/m, standard, the larger one's
};

struct ContactFit {
  std::optional<FittedNormal> normal;
  std::optional<FittedCurvature> curvature;
  std::string no_normal, no_curvature;  // why not; empty: determined
};

struct ContactFitOptions {
  /// Of the texels' forces from one another, relative: gains that differ and are not known. What
  /// the fit leaves of the depths counts where it is more.
  double gain_deviation = 0.05;
  double largest_tilt_deviation = 0.2;      // rad, beyond it the normal is not determined
  double largest_curvature_deviation = 50;  // 1/m
};

/// Fits the surface that presses the foam in. Each touched texel that is not full gives a point,
/// rest_depth() behind the face; through them, in the frame of `center_P` and the mean normal,
///   w(u, v) = a + b u + c v + (d u^2 + 2 e u v + f v^2) / 2
/// by least squares; its normal and the eigenvalues of its shape operator at the centre. Where six
/// points do not determine the quadric, a plane is taken; three points or a line determine nothing.
/// Texels are taken to give way by themselves: foam that spreads a load makes surfaces look
/// flatter.
ContactFit fit_contact(const FeltPad& pad, const FeltTexels& felt, const Eigen::Vector3d& center_P,
                       const ContactFitOptions& options = {});

}  // namespace prehend::touch
