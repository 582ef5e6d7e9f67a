#pragma once

#include <memory>
#include <vector>

#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/pad_on_body.h"

namespace prehend::simulation::engines {

/// Gives an engine that knows nothing of texels tactile pads: the scene's step is divided, and in
/// each sub-step the pads' forces at the present state act on bodies as outer wrenches, equal and
/// opposite. The engine does all else. A scene without pads goes through unchanged.
///
/// Stability. Pads act explicitly, on engines that integrate velocities first and positions with
/// them. For one mode of stiffness K and damping C over mass, with forces taken where the present
/// velocity leads, x+ = x + h v+, v+ = v - h (K (x + h v) + C v), the Jury conditions ask for
///   3 h^2 K + 2 h C < 4.
/// substep_limit() bounds K and C of all modes that pads can make. A scene whose limit is below
/// kLeastSubstep is refused; `native` couples pads implicitly and has no limit.
class SubsteppedPads : public Engine {
 public:
  static constexpr double kLeastSubstep = 1e-6;  // s

  explicit SubsteppedPads(std::unique_ptr<Engine> engine);

  std::string name() const override { return engine_->name(); }
  std::string version() const override { return engine_->version(); }
  std::vector<std::string> solvers() const override { return engine_->solvers(); }
  void load(const EngineScene& scene) override;
  void step() override;
  void set_joint_force(int joint, double force) override;
  void set_body_wrench(int body, const Vector6& wrench_W) override;
  BodyMotion body(int index) const override { return engine_->body(index); }
  double joint_position(int joint) const override { return engine_->joint_position(joint); }
  std::vector<double> pad_forces(int pad) const override;
  std::vector<double> save() const override;
  void restore(const std::vector<double>& state) override;

  int substeps() const { return substeps_; }  // of a step

 private:
  void press(double h);

  std::unique_ptr<Engine> engine_;
  EngineScene scene_;
  int substeps_ = 1;
  std::vector<PadOnBody> touches_;
  std::vector<contact::PadState> states_;  // of each
  std::vector<Vector6> wrenches_;          // from outside, of each body
  std::vector<Vector6> with_pads_;         // and of the pads, in the present sub-step
  std::vector<char> touched_;              // bodies that pads can push
  std::vector<BodyMotion> motions_;        // of those
};

/// The longest stable sub-step [s] of a scene with pads; infinity where no pad can touch a body
/// that moves. A pad that is covered whole has K = sum k, C = sum c of its texels (or their
/// bristles' constants where larger). Of a body pressed by several pads the sums add. A body on a
/// joint to the world moves along it only; a point of another one gives way by (1 + s/2) / mass, s
/// the largest mass rho^2 / moment over its principal axes (rho: greatest distance from the axis):
/// 2.5 / mass for boxes, which is exact for shear on the face of a cube.
double substep_limit(const EngineScene& scene);

}  // namespace prehend::simulation::engines
