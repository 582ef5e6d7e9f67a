#pragma once

#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "prehend/robot/gripper_model.h"
#include "prehend/robot/pad_calibration.h"
#include "prehend/simulation/sensors/pad_sensor.h"
#include "prehend/simulation/state_bytes.h"
#include "prehend/simulation/tactile_sensor.h"

namespace prehend::simulation {

/// The pads' electronics. Rows, columns, counts and full scale are those of each pad.
struct TactileOptions {
  TactileOptions() { sensor.threshold = 0; }
  TactileSensorOptions sensor;  // ideal without threshold; pad k has seed + k
  /// In place of `sensor`, of which the seed counts alone then; null: none.
  std::shared_ptr<const PadSensorModel> model;
  std::map<std::string, double> parameters;  // of `model`, those that are not its defaults
  double period = 0.01;                      // s, between frames of a sensor that is not ideal
  contact::FoamMemory foam;  // of pads whose law has none of its own; `sensor` apart

  /// Whether frames depend on the present forces alone, and so may be asked for at any time. Not of
  /// a `model`: nobody knows.
  bool is_ideal() const { return !model && sensor.is_ideal() && calibrations.empty(); }
  /// "foam", or the model's name.
  std::string sensor_name() const;
  /// "ideal", "realistic", "dead_rows (count 2, first 3)".
  std::string about() const;
  /// None, one for all pads, or one for each in their order: of what was measured.
  std::vector<robot::PadCalibration> calibrations;
  const robot::PadCalibration* calibration(int number) const;  // of that pad; null: none

  /// Law of pad `number`: its own or as calibrated, with `foam` where neither remembers.
  contact::TexelLaw law_of(const robot::TactilePadModel& pad, int number) const;
  /// `sensor` of pad `number` of a robot, as calibrated.
  TactileSensorOptions of_pad(const robot::TactilePadModel& pad, int number) const;
};

/// A plug-in's sensor as a value: what it saves is all of it.
class PlugInSensor {
 public:
  /// @throws std::invalid_argument for a parameter that the model does not know or that is out of
  /// its bounds, and what the model throws.
  PlugInSensor(const TactileOptions& options, const robot::TactilePadModel& pad, int number);
  PlugInSensor(const PlugInSensor& other);
  PlugInSensor(PlugInSensor&&) noexcept = default;
  PlugInSensor& operator=(const PlugInSensor& other) { return *this = PlugInSensor(other); }
  PlugInSensor& operator=(PlugInSensor&&) noexcept = default;
  ~PlugInSensor() = default;

  /// @throws std::runtime_error naming the sensor when it does not give a frame of this pad.
  TactileFrameReading sample(const std::vector<double>& forces, double dt);

  template <class Archive>
  void archive(Archive& archive) {
    std::vector<double> state = sensor_->save();
    archive(same_size(state));
    if constexpr (std::is_same_v<Archive, StateReader>) sensor_->restore(state);
  }

 private:
  std::unique_ptr<PadSensor> make() const;

  std::shared_ptr<const PadSensorModel> model_;
  PadTexels texels_;
  std::map<std::string, double> values_;
  std::uint32_t seed_;
  std::unique_ptr<PadSensor> sensor_;
};

/// One pad's electronics, whichever they are. Their state is their value.
class PadElectronics {
 public:
  /// @throws std::invalid_argument naming the option.
  PadElectronics(const TactileOptions& options, const robot::TactilePadModel& pad, int number);

  /// The frame `dt` [s] after the last one for the texels' normal forces [N], rows * columns.
  TactileFrameReading sample(const std::vector<double>& forces, double dt);

  template <class Archive>
  void archive(Archive& archive) {
    std::visit([&archive](auto& sensor) { sensor.archive(archive); }, sensor_);
  }

 private:
  std::variant<TactileSensor, PlugInSensor> sensor_;
};

}  // namespace prehend::simulation
