#include "prehend/robot/gripper_model.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <type_traits>

#include "prehend/contact/compression_curve.h"
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

// Every field of one gripper, or of several side by side.
template <class Visit, class... Models>
void visit_fields(const Visit& visit, Models&... models) {
  visit("name", models.name...);
  visit("max_opening", models.max_opening...);
  visit("max_speed", models.max_speed...);
  visit("max_acceleration", models.max_acceleration...);
  visit("nominal_current", models.nominal_current...);
  visit("max_current", models.max_current...);
  visit("force_per_current", models.force_per_current...);
  visit("friction_force", models.friction_force...);
  visit("jaw_mass", models.jaw_mass...);
  visit("mass", models.mass...);
  visit("finger_size", models.finger_size...);
  visit("tip_margin", models.tip_margin...);
  visit("housing_size", models.housing_size...);
}

template <class Visit, class... Pads>
void visit_pad_fields(const Visit& visit, Pads&... pads) {
  visit("rows", pads.rows...);
  visit("columns", pads.columns...);
  visit("texel_pitch", pads.texel_pitch...);
  visit("thickness", pads.thickness...);
  visit("newton_per_count", pads.newton_per_count...);
  visit("full_scale", pads.full_scale...);
}

template <class Visit, class... Laws>
void visit_law_fields(const Visit& visit, Laws&... laws) {
  visit("law.stiffness", laws.stiffness...);
  visit("law.damping", laws.damping...);
  visit("law.bristle_stiffness", laws.bristle_stiffness...);
  visit("law.bristle_damping", laws.bristle_damping...);
  visit("law.viscous_friction", laws.viscous_friction...);
  visit("law.static_friction", laws.static_friction...);
  visit("law.dynamic_friction", laws.dynamic_friction...);
  visit("law.stribeck_velocity", laws.stribeck_velocity...);
  visit("law.normal_law", laws.normal_law...);
  visit("law.exponent", laws.exponent...);
  visit("law.bristle_law", laws.bristle_law...);
  visit("law.elastic_limit", laws.elastic_limit...);
  visit("law.return_map", laws.return_map...);
}

template <class Value>
auto in_one_line(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return static_cast<int>(value);
  } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
    return value.transpose();
  } else {
    return value;
  }
}

GripperModel gripper_of(const YAML::Node& node, const std::filesystem::path& path) {
  GripperModel model;
  text::YamlMap map(node, path, "gripper");
  visit_fields([&map](const char* key, auto& value) { map.read(key, value); }, model);
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
  return gripper_of(text::load_yaml_map(path), path);
}

GripperModel parse_gripper_model(const std::string& yaml, const std::filesystem::path& path) {
  return gripper_of(text::parse_yaml_map(yaml, path), path);
}

std::vector<std::string> differences(const GripperModel& a, const GripperModel& b) {
  std::vector<std::string> result;
  const auto compare = [&result](const std::string& name, const auto& x, const auto& y) {
    if (x == y) return;
    std::ostringstream words;
    words << name << ": " << in_one_line(x) << " and " << in_one_line(y);
    result.push_back(words.str());
  };
  visit_fields(compare, a, b);
  const auto compare_pad = [&](const std::string& name, const auto& x, const auto& y) {
    compare("pad." + name, x, y);
  };
  visit_pad_fields(compare_pad, a.pad, b.pad);
  visit_law_fields(compare_pad, a.pad.law, b.pad.law);
  const auto at_half = [](const TactilePadModel& pad) {
    return pad.law.curve ? pad.law.curve->force(pad.thickness / 2) : 0;
  };
  compare("pad.law.curve at half the thickness", at_half(a.pad), at_half(b.pad));
  if (!(a.pad.law.memory == b.pad.law.memory)) {
    result.push_back("pad.law: creep or hysteresis of the foam");
  }
  return result;
}

}  // namespace prehend::robot
