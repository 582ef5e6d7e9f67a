#include "prehend/robot/pad_calibration.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/contact/require.h"
#include "prehend/contact/texel.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/robot/texel_law_yaml.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {
namespace {

std::vector<double> numbers_at(text::YamlMap& map, const std::string& key) {
  const YAML::Node list = map.child(key);
  std::vector<double> numbers;
  if (!list.IsDefined()) return numbers;
  const std::string mend = "Write one number for each texel, row by row: [1, 0.98, ...]";
  if (!list.IsSequence()) map.fail(key, "is no list", mend);
  for (const YAML::Node& entry : list) {
    double number = 0;
    if (!entry.IsScalar() || !YAML::convert<double>::decode(entry, number)) {
      map.fail(key, "has an entry that is no number", mend);
    }
    numbers.push_back(number);
  }
  return numbers;
}

PadCalibration calibration_of(const YAML::Node& node, const std::filesystem::path& path) {
  PadCalibration calibration;
  text::YamlMap map(node, path, "calibration");
  map.read("rows", calibration.rows);
  map.read("columns", calibration.columns);
  map.read("newton_per_count", calibration.newton_per_count);
  calibration.gains = numbers_at(map, "gains");
  calibration.zeros = numbers_at(map, "zeros");
  map.read("noise", calibration.noise);
  if (const YAML::Node node_of_law = map.child("law")) {
    for (const auto& entry : node_of_law) {
      const std::string key = entry.first.Scalar();
      if (key == "stiffness" || key == "damping" || key == "creep" || key == "hysteresis") continue;
      map.fail(
          "law", "has '" + key + "', which no calibration measures",
          "Write stiffness, damping, creep and hysteresis; the rest belongs to the pad's own law");
    }
    contact::TexelLaw law;
    read_texel_law(node_of_law, path, "calibration.law", law);
    if (node_of_law["stiffness"]) calibration.stiffness = law.stiffness;
    if (node_of_law["damping"]) calibration.damping = law.damping;
    calibration.memory = law.memory;
  }
  map.finish();
  try {
    validate(calibration);
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(path.string() + ": " + error.what(), "Correct that value");
  }
  return calibration;
}

}  // namespace

contact::TexelLaw PadCalibration::law_over(const contact::TexelLaw& law) const {
  contact::TexelLaw measured = law;
  if (stiffness) measured.stiffness = *stiffness;
  if (damping) measured.damping = *damping;
  if (memory.terms() > 0) measured.memory = memory;
  return measured;
}

void validate(const PadCalibration& calibration) {
  using contact::require;
  require(calibration.rows > 0 && calibration.columns > 0, "PadCalibration::rows and columns",
          "positive");
  contact::require_positive(calibration.newton_per_count, "PadCalibration::newton_per_count");
  contact::require_not_negative(calibration.noise, "PadCalibration::noise");
  const auto texels = static_cast<std::size_t>(calibration.rows * calibration.columns);
  const auto check = [&](const std::vector<double>& values, const std::string& name) {
    if (values.empty() || values.size() == texels) return;
    throw std::invalid_argument(
        fmt::format("{} has {} values for {} texels", name, values.size(), texels));
  };
  check(calibration.gains, "PadCalibration::gains");
  check(calibration.zeros, "PadCalibration::zeros");
  double sum = 0;
  for (const double gain : calibration.gains) {
    contact::require_not_negative(gain, "PadCalibration::gains");
    sum += gain;
  }
  require(calibration.gains.empty() || sum > 0, "PadCalibration::gains", "positive somewhere");
  for (const double zero : calibration.zeros) {
    require(std::isfinite(zero), "PadCalibration::zeros", "finite");
  }
  contact::validate(calibration.law_over({}));
}

void require_of(const PadCalibration& calibration, const TactilePadModel& pad) {
  if (calibration.rows != pad.rows || calibration.columns != pad.columns) {
    throw std::invalid_argument(
        fmt::format("the calibration is of {} x {} texels, the pad has {} x {}", calibration.rows,
                    calibration.columns, pad.rows, pad.columns));
  }
  if (calibration.stiffness && pad.law.normal_law != contact::NormalLaw::kLinear) {
    throw std::invalid_argument("the calibration's stiffness is of a linear law, the pad's is not");
  }
}

PadCalibration read_pad_calibration(const std::filesystem::path& path) {
  return calibration_of(text::load_yaml_map(path), path);
}

PadCalibration parse_pad_calibration(const std::string& yaml, const std::filesystem::path& path) {
  return calibration_of(text::parse_yaml_map(yaml, path), path);
}

}  // namespace prehend::robot
