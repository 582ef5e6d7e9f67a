#include "prehend/simulation/tactile_sensor.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/contact/require.h"

namespace prehend::simulation {

using contact::require;
using contact::require_not_negative;
using contact::require_positive;

TactileSensorOptions TactileSensorOptions::realistic() {
  TactileSensorOptions options;
  options.gain_spread = 0.05;
  options.pad_gain_spread = 0.2;
  options.hysteresis = 0.04;
  options.creep = 0.06;
  options.low_pass_time = 0.01;
  options.noise = 3;
  return options;
}

bool TactileSensorOptions::is_ideal() const {
  return gain_spread == 0 && pad_gain_spread == 0 && hysteresis == 0 && creep == 0 &&
         low_pass_time == 0 && noise == 0 && dead.empty();
}

TactileSensor::TactileSensor(const TactileSensorOptions& options)
    : options_(options), random_(options.seed) {
  require(options.rows > 0, "TactileSensorOptions::rows", "positive");
  require(options.columns > 0, "TactileSensorOptions::columns", "positive");
  require_positive(options.newton_per_count, "TactileSensorOptions::newton_per_count");
  require(options.full_scale > 0 && options.full_scale <= 65535, "TactileSensorOptions::full_scale",
          "1 to 65535");
  require(options.threshold >= 0, "TactileSensorOptions::threshold", "not negative");
  require_not_negative(options.gain_spread, "TactileSensorOptions::gain_spread");
  require_not_negative(options.pad_gain_spread, "TactileSensorOptions::pad_gain_spread");
  require_not_negative(options.hysteresis, "TactileSensorOptions::hysteresis");
  require_not_negative(options.creep, "TactileSensorOptions::creep");
  require_positive(options.creep_time, "TactileSensorOptions::creep_time");
  require_not_negative(options.low_pass_time, "TactileSensorOptions::low_pass_time");
  require_not_negative(options.noise, "TactileSensorOptions::noise");
  const int count = options.rows * options.columns;
  gain_.assign(count, 1.0);
  if (options.gain_spread > 0) {
    std::normal_distribution<double> spread(1, options.gain_spread);
    for (double& gain : gain_) gain = std::max(0.1, spread(random_));
  }
  if (options.pad_gain_spread > 0) {
    std::normal_distribution<double> spread(1, options.pad_gain_spread);
    const double pad = std::max(0.1, spread(random_));
    for (double& gain : gain_) gain *= pad;
  }
  for (const int texel : options.dead) {
    require(texel >= 0 && texel < count, "TactileSensorOptions::dead", "indices of texels");
    gain_[texel] = 0;
  }
  filtered_.assign(count, 0.0);
  crept_ = highest_ = filtered_;
}

TactileFrameReading TactileSensor::sample(const std::vector<double>& forces, double dt) {
  if (forces.size() != gain_.size()) {
    throw std::invalid_argument("TactileSensor: got " + std::to_string(forces.size()) +
                                " forces for " + std::to_string(gain_.size()) + " texels");
  }
  require_not_negative(dt, "TactileSensor: dt");
  const double blend = options_.low_pass_time > 0 ? -std::expm1(-dt / options_.low_pass_time) : 1.0;
  const double creeping = -std::expm1(-dt / options_.creep_time);
  std::normal_distribution<double> noise(0, options_.noise);
  TactileFrameReading frame;
  frame.rows = options_.rows;
  frame.columns = options_.columns;
  frame.full_scale = options_.full_scale;
  frame.threshold = options_.threshold;
  frame.counts.reserve(forces.size());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    filtered_[i] += blend * (forces[i] - filtered_[i]);
    crept_[i] += creeping * (options_.creep * filtered_[i] - crept_[i]);
    // Unloading: part of what was pressed most is still shown; gone when the force is.
    highest_[i] = std::max(filtered_[i], highest_[i]);
    if (filtered_[i] <= 0.01 * highest_[i]) highest_[i] = filtered_[i];
    const double below = highest_[i] > 0 ? 1 - filtered_[i] / highest_[i] : 0.0;
    const double hysteresis = options_.hysteresis * 4 * below * (1 - below) * highest_[i];
    double counts = gain_[i] * (filtered_[i] + crept_[i] + hysteresis) / options_.newton_per_count;
    if (options_.noise > 0 && gain_[i] > 0) counts += noise(random_);
    frame.felt += std::max(0.0, counts) * options_.newton_per_count;
    const double whole =
        std::clamp(std::round(counts), 0.0, static_cast<double>(options_.full_scale));
    frame.counts.push_back(whole < options_.threshold ? std::uint16_t{0}
                                                      : static_cast<std::uint16_t>(whole));
    frame.sum += frame.counts.back() * options_.newton_per_count;
  }
  return frame;
}

WrenchSensor::WrenchSensor(const WrenchSensorOptions& options)
    : options_(options), random_(options.seed) {
  require_not_negative(options.force_noise, "WrenchSensorOptions::force_noise");
  require_not_negative(options.torque_noise, "WrenchSensorOptions::torque_noise");
  require_positive(options.force_resolution, "WrenchSensorOptions::force_resolution");
  require_positive(options.torque_resolution, "WrenchSensorOptions::torque_resolution");
  require_positive(options.force_range, "WrenchSensorOptions::force_range");
  require_positive(options.torque_range, "WrenchSensorOptions::torque_range");
  require(options.bias.allFinite(), "WrenchSensorOptions::bias", "finite");
}

Eigen::Matrix<double, 6, 1> WrenchSensor::sample(const Eigen::Matrix<double, 6, 1>& wrench) {
  std::normal_distribution<double> noise;
  Eigen::Matrix<double, 6, 1> shown;
  for (int i = 0; i < 6; ++i) {
    const bool force = i < 3;
    const double deviation = force ? options_.force_noise : options_.torque_noise;
    const double range = force ? options_.force_range : options_.torque_range;
    const double resolution = force ? options_.force_resolution : options_.torque_resolution;
    double value = wrench[i] + options_.bias[i];
    if (deviation > 0) value += deviation * noise(random_);
    shown[i] = std::clamp(resolution * std::round(value / resolution), -range, range);
  }
  return shown;
}

}  // namespace prehend::simulation
