#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "prehend/simulation/sensors/pad_sensor.h"
#include "prehend/text/plug_ins.h"

namespace prehend::simulation {

inline constexpr const char* kDefaultSensor = "foam";

/// Pads' electronics by name: `foam` (the default: TactileSensor), and each plug-in in the folders
/// of PREHEND_SENSORS and in ../lib/prehend/sensors beside the running program
/// (text::plug_in_folders()).
class SensorRegistry {
 public:
  SensorRegistry();
  explicit SensorRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return sensors_.names(); }  // sorted
  /// For TactileOptions::model: null for `foam`.
  /// @throws std::invalid_argument naming the nearest and all that there are.
  std::shared_ptr<const PadSensorModel> create(const std::string& name) const;
  const std::vector<text::PlugInProblem>& problems() const { return sensors_.problems(); }

 private:
  text::NamedPlugIns<PadSensorModel> sensors_;
};

}  // namespace prehend::simulation
