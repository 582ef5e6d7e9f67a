#pragma once

#include <memory>
#include <vector>

#include "prehend/contact/grasp_stepper.h"
#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// prehend's own engine: contact::GraspSystem. One free body over the ground, between bodies on
/// prismatic joints that carry pads; pads are coupled implicitly. It has no contact without pads
/// but that with the ground, no revolute joints and no chains: such scenes are refused.
class NativeEngine : public Engine {
 public:
  std::string name() const override { return "native"; }
  std::string version() const override;
  std::vector<std::string> solvers() const override { return {"first_order", "second_order"}; }
  void load(const EngineScene& scene) override;
  void step() override;
  void set_joint_force(int joint, double force) override;
  void set_body_wrench(int body, const Vector6& wrench_W) override;
  BodyMotion body(int index) const override;
  double joint_position(int joint) const override;
  std::vector<double> pad_forces(int pad) const override;
  std::vector<double> save() const override;
  void restore(const std::vector<double>& state) override;

 private:
  EngineScene scene_;
  int free_body_ = -1;
  std::unique_ptr<contact::GraspStepper> stepper_;
};

}  // namespace prehend::simulation::engines
