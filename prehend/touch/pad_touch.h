#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/contact_fit.h"
#include "prehend/touch/felt_pad.h"

namespace prehend::touch {

struct PadTouchOptions {
  double friction = 0;  // of the pad on what it touches; 0: the law's dynamic friction
  ContactFitOptions fit;
};

/// What one frame of a pad means. Pad frame P, SI units. What a frame does not tell is empty, and
/// `not_determined` says why.
struct PadTouch {
  int texels = 0, touched = 0;
  int full = 0;        // of the touched: force, pressure and torque are at least what is said
  int unreadable = 0;  // left out
  double area = 0;     // m^2, of the touched texels
  double force = 0;    // N, normal, sum of the touched texels'
  double largest_pressure = 0;            // Pa
  std::optional<Eigen::Vector3d> center;  // m, of pressure: mean of the texels by their force
  std::optional<FittedNormal> normal;
  std::optional<FittedCurvature> curvature;
  /// N m, about the normal through the centre of pressure: sum of mu F r over the texels, the
  /// largest torque that friction holds while nothing pulls sideways (contact::holding_torque; mu
  /// times the integral of p r dA of a soft finger).
  std::optional<double> holding_torque;
  double friction = 0;                      // mu of the holding torque
  std::vector<std::string> not_determined;  // "curvature: 4 texels to fit, 6 are needed"
};

/// @param counts of the texels, in the layout's order; what is not finite or negative is left out.
/// @throws std::invalid_argument for another number of counts than the pad has texels.
PadTouch pad_touch(const FeltPad& pad, const std::vector<double>& counts,
                   const PadTouchOptions& options = {});

}  // namespace prehend::touch
