#include "prehend/contact/pad_readings.h"

#include <cmath>
#include <numeric>
#include <stdexcept>

#include <Eigen/Geometry>

namespace prehend::contact {

double total_normal_force(const PadLayout& pad, const PadState& state) {
  const auto begin = state.normal_force.begin();
  return std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(pad.size()), 0.0);
}

std::vector<double> pressure(const PadLayout& pad, const PadState& state) {
  std::vector<double> result(pad.size());
  for (std::size_t i = 0; i < pad.size(); ++i) {
    if (pad.area(i) > 0) result[i] = state.normal_force[i] / pad.area(i);
  }
  return result;
}

Eigen::Vector3d centre_of_pressure(const PadLayout& pad, const PadState& state) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double force = 0;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    sum += state.normal_force[i] * pad.position(i);
    force += state.normal_force[i];
  }
  return force > 0 ? Eigen::Vector3d(sum / force) : sum;
}

double holding_torque(const PadLayout& pad, const PadState& state, double friction) {
  if (!(std::isfinite(friction) && friction >= 0)) {
    throw std::invalid_argument("holding_torque: friction must be finite and not negative");
  }
  const Eigen::Vector3d centre = centre_of_pressure(pad, state);
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < pad.size(); ++i) axis += state.normal_force[i] * pad.normal(i);
  if (axis.norm() == 0) return 0;
  axis.normalize();
  double torque = 0;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    torque += friction * state.normal_force[i] * axis.cross(pad.position(i) - centre).norm();
  }
  return torque;
}

double rectangle_holding_torque(double friction, double force, double a, double b) {
  if (!(a > 0 && b > 0)) {
    throw std::invalid_argument("rectangle_holding_torque: sides must be positive");
  }
  const double diagonal = std::hypot(a, b);
  return friction * force / 6 *
         (diagonal + a * a / (2 * b) * std::log((b + diagonal) / a) +
          b * b / (2 * a) * std::log((a + diagonal) / b));
}

std::vector<SlipState> slip_states(const PadLayout& pad, const TexelLaw& law, const PadState& state,
                                   double share) {
  std::vector<SlipState> states(pad.size(), SlipState::kFree);
  for (std::size_t i = 0; i < pad.size(); ++i) {
    if (state.normal_force[i] <= 0) continue;
    const double bristle_force =
        pad.scale[i] * law.bristle_stiffness * std::hypot(state.bristle_u[i], state.bristle_v[i]);
    const bool slips = bristle_force >= share * law.dynamic_friction * state.normal_force[i];
    states[i] = slips ? SlipState::kSlips : SlipState::kSticks;
  }
  return states;
}

}  // namespace prehend::contact
