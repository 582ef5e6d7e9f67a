#include "prehend/simulation/robot_sensors.h"

#include <algorithm>
#include <cmath>

#include "prehend/contact/require.h"

namespace prehend::simulation {

RobotSensors::RobotSensors(const robot::HandModel& hand, const TactileOptions& tactile,
                           const std::optional<WrenchSensorOptions>& wrench)
    : tactile_(tactile) {
  if (wrench) wrist_.emplace(*wrench);
  contact::require(
      tactile.calibrations.size() <= 1 || tactile.calibrations.size() == hand.pads.size(),
      "tactile.calibration", "one file, or one for each pad of the hand");
  for (const robot::HandPad& pad : hand.pads) {
    const int number = static_cast<int>(pads_.size());
    pad_options_.push_back(tactile.of_pad(pad.model, number));
    pads_.emplace_back(tactile, pad.model, number);
    frames_.emplace_back(pad.layout->size(), 0);
    layouts_.push_back(pad.layout);
  }
  age_ = tactile.period;  // the first frame is due at once
}

std::vector<std::uint16_t> RobotSensors::ideal_counts(std::size_t pad,
                                                      const std::vector<double>& forces) const {
  const TactileSensorOptions& options = pad_options_[pad];
  std::vector<std::uint16_t> counts;
  counts.reserve(forces.size());
  for (const double force : forces) {
    const double count = std::floor(force / options.newton_per_count);
    counts.push_back(static_cast<std::uint16_t>(std::min<double>(count, options.full_scale)));
  }
  return counts;
}

bool RobotSensors::frames_due(double h) {
  if (ideal_pads()) return false;
  age_ += h;
  return age_ >= tactile_.period * (1 - 1e-9);
}

void RobotSensors::take_frame(std::size_t pad, const std::vector<double>& forces) {
  frames_[pad] = pads_[pad].sample(forces, age_).counts;
  for (std::size_t i = 0; i < frames_[pad].size(); ++i) {
    if (layouts_[pad]->area(i) == 0) frames_[pad][i] = 0;  // there is no cell to be noisy
  }
  if (pad + 1 == pads_.size()) age_ = 0;
}

ContactWrench RobotSensors::shown(const ContactWrench& wrench) {
  if (!wrist_) return wrench;
  Eigen::Matrix<double, 6, 1> felt;
  felt << wrench.force, wrench.torque;
  felt = wrist_->sample(felt);
  return {felt.head<3>(), felt.tail<3>()};
}

}  // namespace prehend::simulation
