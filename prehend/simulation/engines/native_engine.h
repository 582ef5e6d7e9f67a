#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// prehend's own engine: contacts and pads coupled implicitly, solved directly. One body between
/// pads on prismatic joints goes to contact::GraspSystem, which allocates nothing and is fastest;
/// every other scene to Multibody.
class NativeEngine : public Engine {
 public:
  NativeEngine();
  std::string name() const override { return "native"; }
  std::string version() const override { return engine_->version(); }
  std::vector<std::string> solvers() const override { return engine_->solvers(); }
  void load(const EngineScene& scene) override;
  void step() override { engine_->step(); }
  void set_joint_force(int joint, double force) override { engine_->set_joint_force(joint, force); }
  void set_body_wrench(int body, const Vector6& wrench_W) override {
    engine_->set_body_wrench(body, wrench_W);
  }
  BodyMotion body(int index) const override { return engine_->body(index); }
  double joint_position(int joint) const override { return engine_->joint_position(joint); }
  std::vector<double> pad_forces(int pad) const override { return engine_->pad_forces(pad); }
  std::vector<double> save() const override { return engine_->save(); }
  void restore(const std::vector<double>& state) override { engine_->restore(state); }

 private:
  std::unique_ptr<Engine> engine_;  // of the present scene
};

}  // namespace prehend::simulation::engines
