#pragma once

#include <memory>
#include <vector>

#include "prehend/contact/grasp_stepper.h"
#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// `native` for one free body over the ground, between pads on fixed bodies and on prismatic
/// joints: contact::GraspSystem.
class GraspEngine : public Engine {
 public:
  /// What of a scene is more than that; empty: nothing.
  static std::string why_not(const EngineScene& scene);

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
  void push(int joint);

  EngineScene scene_;
  int free_body_ = -1;
  std::vector<double> joint_forces_, wrench_forces_;  // N, of each joint
  std::unique_ptr<contact::GraspStepper> stepper_;
};

}  // namespace prehend::simulation::engines
