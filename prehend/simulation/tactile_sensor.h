#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/gripper_model.h"
#include "prehend/simulation/state_bytes.h"

namespace prehend::simulation {

/// A frame as the controller of a Weiss DSA pad gives it.
struct TactileFrameReading {
  int rows = 0, columns = 0;
  std::vector<std::uint16_t> counts;  // rows * columns, 0 to full_scale, row 0 at the fingertip
  double sum = 0;                     // N, of the counts
  double felt = 0;                    // N, before rounding, threshold and full scale
  int full_scale = 4095;              // counts
  int threshold = 10;                 // counts, below it a texel says 0
};

/// From texel forces to counts. The defaults are an ideal 12-bit pad; realistic() is not.
struct TactileSensorOptions {
  int rows = 14, columns = 6;
  double newton_per_count = robot::kDsaNewtonPerCount;
  int full_scale = 4095;
  int threshold = 10;          // counts
  double gain_spread = 0;      // standard deviation of the texels' gains, relative
  double pad_gain_spread = 0;  // the same from pad to pad
  double hysteresis = 0;       // share of the force that unloading shows too much, at most
  double creep = 0;            // share that a constant force adds in the long run
  double creep_time = 10;      // s
  double low_pass_time = 0;    // s, of the foam
  double noise = 0;            // counts, standard deviation
  std::vector<int> dead;       // texels that always say 0
  std::uint32_t seed = 1;

  /// Foam and electronics of a used pad: 5 % gains, 20 % from pad to pad (figure 5a of the
  /// soft-contact paper shows sums that differ clearly), 4 % hysteresis, 6 % creep, 10 ms, 3
  /// counts.
  static TactileSensorOptions realistic();
  /// Whether a frame depends on the present forces alone.
  bool is_ideal() const;
};

/// One pad's electronics. Same options and samples give the same frames; its state is its value.
class TactileSensor {
 public:
  /// @throws std::invalid_argument naming the option.
  explicit TactileSensor(const TactileSensorOptions& options);

  /// The frame `dt` [s] after the last one for the texels' normal forces [N], rows * columns.
  /// @throws std::invalid_argument for another number of forces or a negative dt.
  TactileFrameReading sample(const std::vector<double>& forces, double dt);

  /// All that changes, for saving: see StateWriter.
  template <class Archive>
  void archive(Archive& archive) {
    archive(same_size(filtered_), same_size(crept_), same_size(highest_), random_);
  }

 private:
  TactileSensorOptions options_;
  std::vector<double> gain_;
  std::vector<double> filtered_, crept_, highest_;  // N
  std::mt19937 random_;
};

/// Wrist force/torque sensor; defaults: resolution, range and noise of the Robotiq FT 300.
struct WrenchSensorOptions {
  double force_noise = 0;            // N, standard deviation; FT 300: about 0.1
  double torque_noise = 0;           // N m
  double force_resolution = 0.01;    // N
  double torque_resolution = 0.001;  // N m
  double force_range = 300;          // N, cut beyond
  double torque_range = 30;          // N m
  Eigen::Matrix<double, 6, 1> bias = Eigen::Matrix<double, 6, 1>::Zero();  // N, N m
  std::uint32_t seed = 1;
};

class WrenchSensor {
 public:
  /// @throws std::invalid_argument naming the option.
  explicit WrenchSensor(const WrenchSensorOptions& options);
  /// Force [N] and torque [N m] as the sensor shows them.
  Eigen::Matrix<double, 6, 1> sample(const Eigen::Matrix<double, 6, 1>& wrench);

  template <class Archive>
  void archive(Archive& archive) {
    archive(random_);
  }

 private:
  WrenchSensorOptions options_;
  std::mt19937 random_;
};

}  // namespace prehend::simulation
