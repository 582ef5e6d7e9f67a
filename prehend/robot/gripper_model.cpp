#include "prehend/robot/gripper_model.h"

#include <cmath>
#include <stdexcept>

#include "prehend/contact/texel.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/texel_law_yaml.h"
#include "prehend/robot/yaml_map.h"

namespace prehend::robot {
namespace {

TactilePadModel read_pad(const YAML::Node& node, const std::filesystem::path& path) {
  TactilePadModel pad;
  YamlMap map(node, path, "pad");
  map.read("rows", pad.rows);
  map.read("columns", pad.columns);
  map.read("texel_pitch", pad.texel_pitch);
  map.read("thickness", pad.thickness);
  map.read("newton_per_count", pad.newton_per_count);
  map.read("full_scale", pad.full_scale);
  const YAML::Node law = map.child("law");
  if (law.IsDefined()) read_texel_law(law, path, "pad.law", pad.law);
  map.finish();
  return pad;
}

void require_positive(double value, const std::string& field) {
  if (!(std::isfinite(value) && value > 0)) {
    throw std::invalid_argument("GripperModel::" + field + " must be finite and positive");
  }
}

}  // namespace

void validate(const GripperModel& model) {
  require_positive(model.max_opening, "max_opening");
  require_positive(model.max_speed, "max_speed");
  require_positive(model.max_acceleration, "max_acceleration");
  require_positive(model.nominal_current, "nominal_current");
  require_positive(model.max_current, "max_current");
  require_positive(model.force_per_current, "force_per_current");
  require_positive(model.friction_force, "friction_force");
  require_positive(model.jaw_mass, "jaw_mass");
  require_positive(model.mass, "mass");
  require_positive(model.finger_size.minCoeff(), "finger_size");
  require_positive(model.housing_size.minCoeff(), "housing_size");
  require_positive(model.pad.rows, "pad.rows");
  require_positive(model.pad.columns, "pad.columns");
  require_positive(model.pad.texel_pitch, "pad.texel_pitch");
  require_positive(model.pad.thickness, "pad.thickness");
  require_positive(model.pad.newton_per_count, "pad.newton_per_count");
  require_positive(model.pad.full_scale, "pad.full_scale");
  if (!std::isfinite(model.tip_margin) || model.tip_margin < 0) {
    throw std::invalid_argument("GripperModel::tip_margin must be finite and not negative");
  }
  if (model.pad.full_scale > 65535) {
    throw std::invalid_argument("GripperModel::pad.full_scale must be at most 65535");
  }
  if (model.pad.thickness >= model.finger_size.y()) {
    throw std::invalid_argument("GripperModel::pad.thickness must be below finger_size.y");
  }
  if (model.nominal_current > model.max_current) {
    throw std::invalid_argument("GripperModel::nominal_current must be at most max_current");
  }
  contact::validate(model.pad.law);
}

GripperModel read_gripper_model(const std::filesystem::path& path) {
  GripperModel model;
  YamlMap map(load_yaml_map(path), path, "gripper");
  map.read("name", model.name);
  map.read("max_opening", model.max_opening);
  map.read("max_speed", model.max_speed);
  map.read("max_acceleration", model.max_acceleration);
  map.read("nominal_current", model.nominal_current);
  map.read("max_current", model.max_current);
  map.read("force_per_current", model.force_per_current);
  map.read("friction_force", model.friction_force);
  map.read("jaw_mass", model.jaw_mass);
  map.read("mass", model.mass);
  map.read("finger_size", model.finger_size);
  map.read("tip_margin", model.tip_margin);
  map.read("housing_size", model.housing_size);
  // What simulation makes of the gripper, see simulation/hardware_yaml.h.
  for (const char* key : {"drive", "tactile", "wrench"}) map.child(key);
  const YAML::Node pad = map.child("pad");
  if (pad.IsDefined()) model.pad = read_pad(pad, path);
  map.finish();
  try {
    validate(model);
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(path.string() + ": " + error.what(), "Correct that value");
  }
  return model;
}

}  // namespace prehend::robot
