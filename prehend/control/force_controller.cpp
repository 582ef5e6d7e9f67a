#include "prehend/control/force_controller.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "prehend/text/require.h"

namespace prehend::control {

void ForceControllerOptions::validate() const {
  const text::Require require{"ForceControllerOptions."};
  require(force_per_current > 0, "force_per_current must be positive");
  require(least_current >= 0, "least_current must not be negative");
  require(largest_current > least_current, "largest_current must exceed least_current");
  require(proportional_gain >= 0, "proportional_gain must not be negative");
  require(integral_gain > 0, "integral_gain must be positive");
  require(force_rate > 0, "force_rate must be positive");
  require(tolerance > 0, "tolerance must be positive");
}

ForceController::ForceController(const ForceControllerOptions& options) : options_(options) {
  options_.validate();
}

void ForceController::start(double target, double felt) {
  if (!(target > 0) || !std::isfinite(target)) {
    throw std::invalid_argument("ForceController: the target force must be positive and finite");
  }
  target_ = target;
  reference_ = std::isfinite(felt) ? std::clamp(felt, 0.0, target) : 0.0;
  integral_ = 0;
  settled_ = false;
  current_ = std::clamp(reference_ / options_.force_per_current, options_.least_current,
                        options_.largest_current);
}

void ForceController::aim(double target) {
  if (!(target > 0) || !std::isfinite(target)) {
    throw std::invalid_argument("ForceController: the target force must be positive and finite");
  }
  target_ = target;
  reference_ = std::min(reference_, target);
  settled_ = false;
}

double ForceController::update(double felt, double dt) {
  if (!std::isfinite(felt) || !(dt > 0)) return current_;
  reference_ = std::min(target_, reference_ + options_.force_rate * dt);
  const double error = reference_ - felt;
  const bool within = std::abs(error) <= options_.tolerance * target_;
  settled_ = reference_ == target_ && within;

  const double change = options_.integral_gain * error * dt;
  const auto current_with = [&](double integral) {
    return (reference_ + options_.proportional_gain * error + integral) /
           options_.force_per_current;
  };
  const double wanted = current_with(integral_ + change);
  const bool winds_up = (wanted > options_.largest_current && change > 0) ||
                        (wanted < options_.least_current && change < 0);
  if (!settled_ && !winds_up) integral_ += change;
  current_ = std::clamp(current_with(integral_), options_.least_current, options_.largest_current);
  return current_;
}

}  // namespace prehend::control
