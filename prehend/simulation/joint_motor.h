#pragma once

#include "prehend/simulation/actuator.h"
#include "prehend/simulation/dc_motor.h"

namespace prehend::simulation {

/// The actuator `dc_motor`: a DC motor (dc_motor.h) behind a gear, at a joint that slides behind a
/// spindle too. With N the turns of the rotor [rad] for each rad or m of the joint:
///   effort = efficiency k N i,   V = R i + k N v,   inertia N^2 J
/// kPosition: the hand's position loop asks for an effort, which goes to the motor as a current.
/// State: current [A], temperature of the winding [degrees Celsius].
class JointDcMotor final : public Actuator {
 public:
  std::string name() const override { return "dc_motor"; }
  std::string about() const override { return "a DC motor with gear, back-EMF and heat"; }
  std::vector<ActuatorParameter> parameters() const override;
  void configure(const ActuatedJoint& joint, const std::vector<double>& values) override;
  bool takes(robot::JointMode) const override { return true; }
  ActuatorMechanics mechanics() const override;
  std::vector<double> initial_state(double position) const override;
  contact::SlideCommand drive(const ActuatorRequest& request, double h, const JointMotion& start,
                              std::span<double> state) const override;
  void observe(double h, const JointMotion& end, double effort,
               std::span<double> state) const override;
  double current(std::span<const double> state) const override { return state[0]; }

 private:
  double effort_per_current() const { return efficiency_ * model_.torque_constant * ratio_; }

  DcMotorModel model_;
  ActuatedJoint joint_;
  double ratio_ = 1;       // N
  double efficiency_ = 1;  // of the gear
  double friction_ = 0;    // N m at the joint
  double damping_ = 0;     // N m s/rad at the joint
};

}  // namespace prehend::simulation
