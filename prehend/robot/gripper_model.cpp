#include "prehend/robot/gripper_model.h"

#include <cmath>
#include <stdexcept>

#include "prehend/contact/texel.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/tactile_pad_yaml.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {
namespace {

void require_positive(double value, const std::string& field,
                      const std::string& of = "GripperModel") {
  if (!(std::isfinite(value) && value > 0)) {
    throw std::invalid_argument(of + "::" + field + " must be finite and positive");
  }
}

}  // namespace

void validate(const TactilePadModel& pad) {
  const auto check = [](double value, const std::string& field) {
    require_positive(value, field, "TactilePadModel");
  };
  check(pad.rows, "rows");
  check(pad.columns, "columns");
  check(pad.texel_pitch, "texel_pitch");
  check(pad.thickness, "thickness");
  check(pad.newton_per_count, "newton_per_count");
  check(pad.full_scale, "full_scale");
  if (pad.full_scale > 65535) {
    throw std::invalid_argument("TactilePadModel::full_scale must be at most 65535");
  }
  contact::validate(pad.law);
}

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
  validate(model.pad);
  if (!std::isfinite(model.tip_margin) || model.tip_margin < 0) {
    throw std::invalid_argument("GripperModel::tip_margin must be finite and not negative");
  }
  if (model.pad.thickness >= model.finger_size.y()) {
    throw std::invalid_argument("GripperModel::pad.thickness must be below finger_size.y");
  }
  if (model.nominal_current > model.max_current) {
    throw std::invalid_argument("GripperModel::nominal_current must be at most max_current");
  }
}

GripperModel read_gripper_model(const std::filesystem::path& path) {
  GripperModel model;
  text::YamlMap map(text::load_yaml_map(path), path, "gripper");
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
  if (pad.IsDefined()) read_tactile_pad(pad, path, "pad", model.pad);
  map.finish();
  try {
    validate(model);
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(path.string() + ": " + error.what(), "Correct that value");
  }
  return model;
}

}  // namespace prehend::robot
