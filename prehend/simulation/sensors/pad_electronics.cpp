#include "prehend/simulation/sensors/pad_electronics.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/simulation/sensors/sensor_registry.h"
#include "prehend/text/nearest_match.h"

namespace prehend::simulation {
namespace {

std::map<std::string, double> all_values(const PadSensorModel& model,
                                         const std::map<std::string, double>& given) {
  std::map<std::string, double> values;
  std::vector<std::string> known;
  for (const PadSensorParameter& parameter : model.parameters()) {
    known.push_back(parameter.name);
    const auto found = given.find(parameter.name);
    const double value = found == given.end() ? parameter.default_value : found->second;
    if (!(value >= parameter.minimum && value <= parameter.maximum)) {
      throw std::invalid_argument(
          fmt::format("tactile.parameters.{} of sensor '{}' must be from {} to {}, not {}",
                      parameter.name, model.name(), parameter.minimum, parameter.maximum, value));
    }
    values[parameter.name] = value;
  }
  for (const auto& [name, value] : given) {
    if (values.contains(name)) continue;
    throw std::invalid_argument(fmt::format("tactile.parameters: sensor '{}' has no '{}'{}",
                                            model.name(), name,
                                            text::nearest_match_hint(name, known)));
  }
  return values;
}

}  // namespace

std::string TactileOptions::sensor_name() const { return model ? model->name() : kDefaultSensor; }

std::string TactileOptions::about() const {
  if (!model) return sensor.is_ideal() ? "ideal" : "realistic";
  std::string values;
  for (const auto& [name, value] : all_values(*model, parameters)) {
    values += fmt::format("{}{} {}", values.empty() ? "" : ", ", name, value);
  }
  return model->name() + (values.empty() ? "" : " (" + values + ")");
}

const robot::PadCalibration* TactileOptions::calibration(int number) const {
  if (calibrations.empty()) return nullptr;
  return &calibrations[calibrations.size() == 1 ? 0 : static_cast<std::size_t>(number)];
}

contact::TexelLaw TactileOptions::law_of(const robot::TactilePadModel& pad, int number) const {
  const robot::PadCalibration* measured = calibration(number);
  contact::TexelLaw law = measured ? measured->law_over(pad.law) : pad.law;
  if (law.memory.terms() == 0) law.memory = foam;
  return law;
}

TactileSensorOptions TactileOptions::of_pad(const robot::TactilePadModel& pad, int number) const {
  TactileSensorOptions options = sensor;
  options.rows = pad.rows;
  options.columns = pad.columns;
  // Cells of a mesh have no rows and columns along which a load could spread.
  if (pad.texel_pitch > 0) {
    options.texel_pitch = pad.texel_pitch;
  } else {
    options.spread = 0;
  }
  options.newton_per_count = pad.newton_per_count;
  options.full_scale = pad.full_scale;
  options.seed += static_cast<std::uint32_t>(number);
  if (const robot::PadCalibration* measured = calibration(number)) {
    require_of(*measured, pad);
    options.newton_per_count = measured->newton_per_count;
    options.gains = measured->gains;
    options.zeros = measured->zeros;
    options.noise = measured->noise;
  }
  return options;
}

PlugInSensor::PlugInSensor(const TactileOptions& options, const robot::TactilePadModel& pad,
                           int number)
    : model_(options.model),
      texels_{pad.rows, pad.columns, pad.newton_per_count, pad.full_scale},
      values_(all_values(*model_, options.parameters)),
      seed_(options.sensor.seed + static_cast<std::uint32_t>(number)),
      sensor_(make()) {}

PlugInSensor::PlugInSensor(const PlugInSensor& other)
    : model_(other.model_),
      texels_(other.texels_),
      values_(other.values_),
      seed_(other.seed_),
      sensor_(make()) {
  sensor_->restore(other.sensor_->save());
}

std::unique_ptr<PadSensor> PlugInSensor::make() const {
  std::unique_ptr<PadSensor> sensor = model_->make(texels_, values_, seed_);
  if (!sensor) throw std::invalid_argument("sensor '" + model_->name() + "' makes nothing");
  return sensor;
}

TactileFrameReading PlugInSensor::sample(const std::vector<double>& forces, double dt) {
  TactileFrameReading frame;
  frame.rows = texels_.rows;
  frame.columns = texels_.columns;
  frame.full_scale = texels_.full_scale;
  frame.threshold = 0;
  frame.counts = sensor_->read(forces, dt);
  const auto is_beyond = [&](std::uint16_t count) { return count > texels_.full_scale; };
  if (frame.counts.size() != forces.size() ||
      std::any_of(frame.counts.begin(), frame.counts.end(), is_beyond)) {
    throw std::runtime_error(fmt::format(
        "sensor '{}', a plug-in, gave {} counts, the largest {}, for {} texels of {} at most",
        model_->name(), frame.counts.size(),
        frame.counts.empty() ? 0 : *std::max_element(frame.counts.begin(), frame.counts.end()),
        forces.size(), texels_.full_scale));
  }
  for (const std::uint16_t count : frame.counts) frame.sum += count * texels_.newton_per_count;
  frame.felt = frame.sum;
  return frame;
}

PadElectronics::PadElectronics(const TactileOptions& options, const robot::TactilePadModel& pad,
                               int number)
    : sensor_([&]() -> std::variant<TactileSensor, PlugInSensor> {
        if (options.model) return PlugInSensor(options, pad, number);
        return TactileSensor(options.of_pad(pad, number));
      }()) {}

TactileFrameReading PadElectronics::sample(const std::vector<double>& forces, double dt) {
  return std::visit([&](auto& sensor) { return sensor.sample(forces, dt); }, sensor_);
}

}  // namespace prehend::simulation
