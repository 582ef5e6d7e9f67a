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
  double texel_pitch = 0.0034;  // m, square
  double newton_per_count = robot::kDsaNewtonPerCount;
  int full_scale = 4095;
  int threshold = 10;          // counts
  double gain_spread = 0;      // standard deviation of the texels' gains, relative
  double pad_gain_spread = 0;  // the same from pad to pad
  std::vector<double> gains;   // of each texel, relative, as measured; empty: 1
  std::vector<double> zeros;   // counts of each texel without load, as measured; empty: 0
  /// Width of the impulse response [m]: a load on one texel is shown by its neighbours as a
  /// Gaussian of this standard deviation. On the pad nothing of it is lost.
  double spread = 0;
  double low_pass_time = 0;  // s
  double latency = 0;        // s, of a frame behind what it shows
  double offset = 0;         // counts, standard deviation of the texels' zeros
  double drift = 0;          // counts by which a zero wanders in an hour, standard deviation
  double ageing = 0;         // share of its gain that a texel loses with each load cycle
  double load_cycles = 0;    // that the texels have had already
  double noise = 0;          // counts, standard deviation
  std::vector<int> dead;     // texels that always say 0
  std::vector<int> dead_rows, dead_columns;
  std::uint32_t seed = 1;

  /// Electronics of a used pad: 5 % gains, 20 % from pad to pad (figure 5a of the soft-contact
  /// paper shows sums that differ clearly), 1.5 mm spread (it names "a strong spatial low-pass"),
  /// 10 ms low pass, 2 ms latency, zeros of 2 counts that wander by 5 in an hour, noise of 3, a
  /// millionth of the gain a cycle. Estimates: no source gives figures.
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
    archive(same_size(filtered_), same_size(zero_), same_size(cycles_), loaded_, history_, random_);
  }

 private:
  std::vector<double> spread_over_pad(const std::vector<double>& forces) const;
  std::vector<double> delayed(double dt);
  void count_cycle(std::size_t texel);

  TactileSensorOptions options_;
  std::vector<double> gain_;
  std::vector<double> row_share_, column_share_;  // of a texel's load in each other row, column
  std::vector<double> filtered_;                  // N
  std::vector<double> zero_;                      // counts
  std::vector<double> cycles_;                    // load cycles of each texel
  std::vector<std::uint8_t> loaded_;              // whether one is under way
  std::vector<double> history_;  // of frames not shown yet: age [s] and forces [N], oldest first
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
