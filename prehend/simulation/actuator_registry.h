#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "prehend/robot/hand_model.h"
#include "prehend/simulation/actuator.h"
#include "prehend/text/plug_ins.h"

namespace prehend::simulation {

/// Actuators by name: `dc_motor`, and each plug-in in the folders of PREHEND_ACTUATORS and in
/// ../lib/prehend/actuators beside the running program (text::plug_in_folders()).
class ActuatorRegistry {
 public:
  ActuatorRegistry();
  explicit ActuatorRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return actuators_.names(); }  // sorted
  /// @throws std::invalid_argument naming the nearest and all that there are.
  std::unique_ptr<Actuator> create(const std::string& name) const;
  /// The actuator of a robot's file, configured.
  /// @throws geometry::InputError "file:line: ..." with the mend: no such actuator, a parameter
  /// that it does not have, is missing, or refused by configure().
  std::shared_ptr<const Actuator> make(const robot::JointMotor& motor,
                                       const ActuatedJoint& joint) const;
  const std::vector<text::PlugInProblem>& problems() const { return actuators_.problems(); }

 private:
  text::NamedPlugIns<Actuator> actuators_;
};

}  // namespace prehend::simulation
