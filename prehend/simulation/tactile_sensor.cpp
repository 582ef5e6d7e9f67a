#include "prehend/simulation/tactile_sensor.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/contact/require.h"

namespace prehend::simulation {

using contact::require;
using contact::require_not_negative;
using contact::require_positive;

namespace {

// A load cycle begins above the one share of the full scale and ends below the other.
constexpr double kCycleBegins = 0.05, kCycleEnds = 0.025;
constexpr double kHour = 3600;  // s

// Share of a load in cell `from` that cell `to` of `count` shows, at from * count + to.
std::vector<double> gaussian_shares(int count, double width) {
  std::vector<double> shares(static_cast<std::size_t>(count) * count);
  for (int from = 0; from < count; ++from) {
    double* row = shares.data() + static_cast<std::ptrdiff_t>(from) * count;
    double sum = 0;
    for (int to = 0; to < count; ++to) {
      const double distance = (to - from) / width;
      sum += row[to] = std::exp(-0.5 * distance * distance);
    }
    for (int to = 0; to < count; ++to) row[to] /= sum;
  }
  return shares;
}

void require_of_each(const std::vector<double>& values, int count, const char* name) {
  require(values.empty() || values.size() == static_cast<std::size_t>(count), name,
          "one value for each texel");
  for (const double value : values) require(std::isfinite(value), name, "finite");
}

void require_within(const std::vector<int>& indices, int count, const char* name,
                    const char* what) {
  for (const int index : indices) require(index >= 0 && index < count, name, what);
}

}  // namespace

TactileSensorOptions TactileSensorOptions::realistic() {
  TactileSensorOptions options;
  options.gain_spread = 0.05;
  options.pad_gain_spread = 0.2;
  options.spread = 0.0015;
  options.low_pass_time = 0.01;
  options.latency = 0.002;
  options.offset = 2;
  options.drift = 5;
  options.ageing = 1e-6;
  options.noise = 3;
  return options;
}

bool TactileSensorOptions::is_ideal() const {
  return gain_spread == 0 && pad_gain_spread == 0 && gains.empty() && zeros.empty() &&
         spread == 0 && low_pass_time == 0 && latency == 0 && offset == 0 && drift == 0 &&
         ageing == 0 && noise == 0 && dead.empty() && dead_rows.empty() && dead_columns.empty();
}

TactileSensor::TactileSensor(const TactileSensorOptions& options)
    : options_(options), random_(options.seed) {
  require(options.rows > 0, "TactileSensorOptions::rows", "positive");
  require(options.columns > 0, "TactileSensorOptions::columns", "positive");
  require_positive(options.texel_pitch, "TactileSensorOptions::texel_pitch");
  require_positive(options.newton_per_count, "TactileSensorOptions::newton_per_count");
  require(options.full_scale > 0 && options.full_scale <= 65535, "TactileSensorOptions::full_scale",
          "1 to 65535");
  require(options.threshold >= 0, "TactileSensorOptions::threshold", "not negative");
  require_not_negative(options.gain_spread, "TactileSensorOptions::gain_spread");
  require_not_negative(options.pad_gain_spread, "TactileSensorOptions::pad_gain_spread");
  require_not_negative(options.spread, "TactileSensorOptions::spread");
  require_not_negative(options.low_pass_time, "TactileSensorOptions::low_pass_time");
  require_not_negative(options.latency, "TactileSensorOptions::latency");
  require_not_negative(options.offset, "TactileSensorOptions::offset");
  require_not_negative(options.drift, "TactileSensorOptions::drift");
  require(options.ageing >= 0 && options.ageing < 1, "TactileSensorOptions::ageing",
          "from 0 to below 1");
  require_not_negative(options.load_cycles, "TactileSensorOptions::load_cycles");
  require(options.load_cycles == 0 || options.ageing > 0, "TactileSensorOptions::load_cycles",
          "left out without ageing");
  require_not_negative(options.noise, "TactileSensorOptions::noise");
  const int count = options.rows * options.columns;
  require_of_each(options.gains, count, "TactileSensorOptions::gains");
  for (const double gain : options.gains) require_not_negative(gain, "TactileSensorOptions::gains");
  require_of_each(options.zeros, count, "TactileSensorOptions::zeros");
  gain_ = options.gains;
  gain_.resize(count, 1.0);
  if (options.gain_spread > 0) {
    std::normal_distribution<double> spread(1, options.gain_spread);
    for (double& gain : gain_) gain *= std::max(0.1, spread(random_));
  }
  if (options.pad_gain_spread > 0) {
    std::normal_distribution<double> spread(1, options.pad_gain_spread);
    const double pad = std::max(0.1, spread(random_));
    for (double& gain : gain_) gain *= pad;
  }
  require_within(options.dead, count, "TactileSensorOptions::dead", "indices of texels");
  require_within(options.dead_rows, options.rows, "TactileSensorOptions::dead_rows",
                 "indices of rows");
  require_within(options.dead_columns, options.columns, "TactileSensorOptions::dead_columns",
                 "indices of columns");
  for (const int texel : options.dead) gain_[texel] = 0;
  for (int i = 0; i < count; ++i) {
    for (const int row : options.dead_rows) gain_[i] *= i / options.columns != row;
    for (const int column : options.dead_columns) gain_[i] *= i % options.columns != column;
  }
  zero_ = options.zeros;
  zero_.resize(count, 0.0);
  if (options.offset > 0) {
    std::normal_distribution<double> offset(0, options.offset);
    for (double& zero : zero_) zero += offset(random_);
  }
  if (options.spread > 0) {
    row_share_ = gaussian_shares(options.rows, options.spread / options.texel_pitch);
    column_share_ = gaussian_shares(options.columns, options.spread / options.texel_pitch);
  }
  filtered_.assign(count, 0.0);
  cycles_.assign(count, options.load_cycles);
  loaded_.assign(count, 0);
}

std::vector<double> TactileSensor::spread_over_pad(const std::vector<double>& forces) const {
  if (options_.spread == 0) return forces;
  const int rows = options_.rows, columns = options_.columns;
  std::vector<double> along(forces.size(), 0.0), both(along);
  for (int r = 0; r < rows; ++r) {
    for (int from = 0; from < columns; ++from) {
      for (int to = 0; to < columns; ++to) {
        along[r * columns + to] += column_share_[from * columns + to] * forces[r * columns + from];
      }
    }
  }
  for (int from = 0; from < rows; ++from) {
    for (int to = 0; to < rows; ++to) {
      const double share = row_share_[from * rows + to];
      for (int c = 0; c < columns; ++c) both[to * columns + c] += share * along[from * columns + c];
    }
  }
  return both;
}

// What was filtered `latency` ago, between the two samples round that time; at first the oldest.
std::vector<double> TactileSensor::delayed(double dt) {
  if (options_.latency == 0) return filtered_;
  const std::size_t size = 1 + filtered_.size();
  for (std::size_t at = 0; at < history_.size(); at += size) history_[at] += dt;
  history_.push_back(0);
  history_.insert(history_.end(), filtered_.begin(), filtered_.end());
  // Of those that are older than the latency only the youngest is needed.
  while (history_.size() > size && history_[size] >= options_.latency) {
    history_.erase(history_.begin(), history_.begin() + static_cast<std::ptrdiff_t>(size));
  }
  std::vector<double> shown(history_.begin() + 1,
                            history_.begin() + static_cast<std::ptrdiff_t>(size));
  if (history_.size() == size || history_[0] <= options_.latency) return shown;
  const double* next = history_.data() + size;
  const double part = (history_[0] - options_.latency) / (history_[0] - next[0]);
  for (std::size_t i = 0; i < shown.size(); ++i) shown[i] += part * (next[1 + i] - shown[i]);
  return shown;
}

void TactileSensor::count_cycle(std::size_t texel) {
  const double share = filtered_[texel] / (options_.full_scale * options_.newton_per_count);
  if (loaded_[texel] == 0 && share > kCycleBegins) loaded_[texel] = 1;
  if (loaded_[texel] == 0 || share >= kCycleEnds) return;
  loaded_[texel] = 0;
  ++cycles_[texel];
}

TactileFrameReading TactileSensor::sample(const std::vector<double>& forces, double dt) {
  if (forces.size() != gain_.size()) {
    throw std::invalid_argument("TactileSensor: got " + std::to_string(forces.size()) +
                                " forces for " + std::to_string(gain_.size()) + " texels");
  }
  require_not_negative(dt, "TactileSensor: dt");
  const double blend = options_.low_pass_time > 0 ? -std::expm1(-dt / options_.low_pass_time) : 1.0;
  std::normal_distribution<double> noise(0, options_.noise), unit;
  TactileFrameReading frame;
  frame.rows = options_.rows;
  frame.columns = options_.columns;
  frame.full_scale = options_.full_scale;
  frame.threshold = options_.threshold;
  frame.counts.reserve(forces.size());
  const std::vector<double> felt = spread_over_pad(forces);
  for (std::size_t i = 0; i < felt.size(); ++i) filtered_[i] += blend * (felt[i] - filtered_[i]);
  const std::vector<double> shown = delayed(dt);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    double gain = gain_[i];
    if (options_.ageing > 0) {
      count_cycle(i);
      gain *= std::pow(1 - options_.ageing, cycles_[i]);
    }
    if (options_.drift > 0) zero_[i] += options_.drift * std::sqrt(dt / kHour) * unit(random_);
    double counts = gain * shown[i] / options_.newton_per_count;
    if (gain > 0) counts += zero_[i];
    if (options_.noise > 0 && gain > 0) counts += noise(random_);
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
