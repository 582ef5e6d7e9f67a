#include "prehend/simulation/joint_motor.h"

#include <algorithm>
#include <numbers>

#include "prehend/contact/require.h"

namespace prehend::simulation {

std::vector<ActuatorParameter> JointDcMotor::parameters() const {
  const DcMotorModel pg70;  // a motor of that size
  return {
      {"supply", "V", "what the electronics can give the motor", {}},
      {"resistance", "Ohm", "of the winding at 25 degrees Celsius", {}},
      {"torque_constant", "N m/A", "of the rotor, and V s of its back-EMF", {}},
      {"gear_ratio", "1", "turns of the rotor for one of the joint, or of its spindle", {}},
      {"rotor_inertia", "kg m^2", "of the rotor alone", {}},
      {"nominal_current", "A", "that the motor bears for good", {}},
      {"peak_current", "A", "for as long as it is not hot; 0: the nominal", 0.0},
      {"spindle_lead", "m", "of a joint that slides: its way for a turn of the spindle", 0.0},
      {"efficiency", "1", "of the gear, in (0, 1]", 1.0},
      {"friction", "N m or N", "Coulomb's, at the joint", 0.0},
      {"viscous_friction", "N m s/rad or N s/m", "at the joint", 0.0},
      {"ambient", "degrees Celsius", "round the motor", pg70.ambient},
      {"thermal_resistance", "K/W", "from winding to ambient", pg70.thermal_resistance},
      {"thermal_capacity", "J/K", "of the winding", pg70.thermal_capacity},
      {"hottest", "degrees Celsius", "that the winding may be", pg70.hottest},
  };
}

void JointDcMotor::configure(const ActuatedJoint& joint, const std::vector<double>& values) {
  using contact::require;
  auto next = values.begin();
  joint_ = joint;
  model_.supply = *next++;
  model_.resistance = *next++;
  model_.torque_constant = *next++;
  const double gear_ratio = *next++;
  model_.rotor_inertia = *next++;
  model_.nominal_current = *next++;
  const double peak = *next++;
  model_.peak_current = peak == 0 ? model_.nominal_current : peak;
  const double lead = *next++;
  efficiency_ = *next++;
  friction_ = *next++;
  damping_ = *next++;
  model_.ambient = *next++;
  model_.thermal_resistance = *next++;
  model_.thermal_capacity = *next++;
  model_.hottest = *next++;
  validate(model_, "");
  contact::require_positive(gear_ratio, "gear_ratio");
  require(efficiency_ > 0 && efficiency_ <= 1, "efficiency", "above 0 and at most 1");
  contact::require_not_negative(friction_, "friction");
  contact::require_not_negative(damping_, "viscous_friction");
  if (joint.slides) {
    contact::require_positive(lead, "spindle_lead");
  } else {
    require(lead == 0, "spindle_lead", "left out: the joint turns");
  }
  ratio_ = joint.slides ? 2 * std::numbers::pi * gear_ratio / lead : gear_ratio;
}

ActuatorMechanics JointDcMotor::mechanics() const {
  return {model_.rotor_inertia * ratio_ * ratio_, friction_, damping_, 0};
}

std::vector<double> JointDcMotor::initial_state(double) const { return {0, model_.ambient}; }

contact::SlideCommand JointDcMotor::drive(const ActuatorRequest& request, double h,
                                          const JointMotion& start, std::span<double> state) const {
  const double K = effort_per_current();
  const DcMotorAtLoad motor{K, model_.torque_constant * ratio_,
                            winding_resistance(model_, state[1]), model_.supply,
                            std::min(bearable_current(model_, state[1]), request.most_effort / K)};
  switch (request.mode) {
    case robot::JointMode::kEffort:
      return motor.at_current(request.value / K, start.velocity);
    case robot::JointMode::kVoltage:
      return motor.at_voltage(request.value, start.velocity);
    default:
      break;
  }
  contact::SlideCommand servo;
  servo.stiffness = joint_.stiffness;
  servo.reference = request.value - h * request.speed;
  servo.damping = joint_.damping;
  servo.speed = request.speed;
  return motor.at_servo(servo, h, start.position, start.velocity);
}

void JointDcMotor::observe(double h, const JointMotion&, double effort,
                           std::span<double> state) const {
  state[0] = effort / effort_per_current();
  state[1] = next_temperature(model_, state[1], state[0], h);
}

}  // namespace prehend::simulation
