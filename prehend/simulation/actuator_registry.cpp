#include "prehend/simulation/actuator_registry.h"

#include <algorithm>
#include <stdexcept>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/joint_motor.h"
#include "prehend/text/nearest_match.h"

namespace prehend::simulation {
namespace {

Actuator* create_dc_motor() { return std::make_unique<JointDcMotor>().release(); }

}  // namespace

ActuatorRegistry::ActuatorRegistry() : ActuatorRegistry(text::plug_in_folders("actuator")) {}

ActuatorRegistry::ActuatorRegistry(const std::vector<std::filesystem::path>& folders)
    : actuators_("actuator", kActuatorInterface, folders, {{"dc_motor", create_dc_motor}}) {}

std::unique_ptr<Actuator> ActuatorRegistry::create(const std::string& name) const {
  return std::unique_ptr<Actuator>(actuators_.find(name)());
}

std::shared_ptr<const Actuator> ActuatorRegistry::make(const robot::JointMotor& motor,
                                                       const ActuatedJoint& joint) const {
  const auto fail = [&motor](const std::string& what, const std::string& mend) {
    throw geometry::InputError(motor.place + ": " + what, mend);
  };
  std::shared_ptr<Actuator> actuator;
  try {
    actuator = create(motor.actuator);
  } catch (const std::invalid_argument& error) {
    fail(error.what(), "Name one of these, or put its library into a folder of PREHEND_ACTUATORS");
  }
  std::vector<std::string> names;
  std::vector<double> values;
  for (const ActuatorParameter& parameter : actuator->parameters()) {
    names.push_back(parameter.name);
    const auto given = motor.values.find(parameter.name);
    if (given == motor.values.end() && !parameter.default_value) {
      fail("'" + parameter.name + "' is missing",
           "Give it in " + parameter.unit + ": " + parameter.about);
    }
    values.push_back(given == motor.values.end() ? *parameter.default_value : given->second);
  }
  for (const auto& [name, value] : motor.values) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    fail(motor.actuator + " has no '" + name + "'" + text::nearest_match_hint(name, names),
         "Correct or remove it");
  }
  try {
    actuator->configure(joint, values);
  } catch (const std::invalid_argument& error) {
    fail(error.what(), "Correct that value");
  }
  return actuator;
}

}  // namespace prehend::simulation
