#include "prehend/simulation/sensors/sensor_registry.h"

namespace prehend::simulation {
namespace {

PadSensorModel* no_sensor() { return nullptr; }

}  // namespace

SensorRegistry::SensorRegistry() : SensorRegistry(text::plug_in_folders("sensor")) {}

SensorRegistry::SensorRegistry(const std::vector<std::filesystem::path>& folders)
    : sensors_("sensor", kSensorInterface, folders, {{kDefaultSensor, no_sensor}}) {}

std::shared_ptr<const PadSensorModel> SensorRegistry::create(const std::string& name) const {
  return std::shared_ptr<const PadSensorModel>(sensors_.find(name)());
}

}  // namespace prehend::simulation
