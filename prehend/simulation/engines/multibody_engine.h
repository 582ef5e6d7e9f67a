#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/simulation/engines/multibody.h"

namespace prehend::simulation::engines {

/// @throws UnsupportedScene for a solver that is neither first_order nor second_order (nor empty).
void check_native_solver(const EngineScene& scene);

/// `native` for all scenes: Multibody by backward Euler, or by SDIRK2 of second order (see
/// contact::GraspStepper) but for steps in which contacts begin or end: backward Euler then, since
/// an impact has no slope to extrapolate.
class MultibodyEngine : public Engine {
 public:
  std::string name() const override { return "native"; }
  std::string version() const override;
  std::vector<std::string> solvers() const override { return {"first_order", "second_order"}; }
  void load(const EngineScene& scene) override;
  void step() override;
  void set_joint_force(int joint, double force) override { system_->set_joint_force(joint, force); }
  void set_body_wrench(int body, const Vector6& wrench_W) override {
    system_->set_body_wrench(body, wrench_W);
  }
  BodyMotion body(int index) const override { return system_->motion(state_, index); }
  double joint_position(int joint) const override { return system_->joint_position(state_, joint); }
  std::vector<double> pad_forces(int pad) const override;
  std::vector<double> save() const override;
  void restore(const std::vector<double>& numbers) override;

  double energy() const { return system_->energy(state_); }  // J, kinetic and gravity's
  const MultibodyState& state() const { return state_; }

 private:
  EngineScene scene_;
  bool second_order_ = false;
  std::unique_ptr<Multibody> system_;
  MultibodyState state_, first_, extrapolated_, next_;
};

}  // namespace prehend::simulation::engines
