#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/simulation/rigid_body.h"
#include "prehend/simulation/scene.h"

namespace prehend::simulation {

namespace engines {
class Engine;
class EngineRegistry;
struct EngineBody;
struct EngineScene;
}  // namespace engines

/// Why a world cannot have an engine of that name, and what mends it.
struct EngineTrouble {
  std::string wrong;  // "is 'mujocco', which is no engine"
  std::string mend;
};
/// None when `name` is native or installed. Loads the plug-ins that are there.
std::optional<EngineTrouble> engine_trouble(const std::string& name);
/// The same with these engines only.
std::optional<EngineTrouble> engine_trouble(const std::string& name,
                                            const engines::EngineRegistry& registry);

/// A plug-in engine under a World (`physics: {engine: NAME}`): it has the objects, the table and
/// what happens between them. The gripper stays prehend's: each step finds what pads, fingers and
/// housing do to the objects, with pads, jaws and objects coupled implicitly as without an engine,
/// and hands it over as one wrench for each object. What the engine's contacts do to an object in
/// the step is not known before; it is taken to be what it was in the step before (`reaction`). An
/// object that is held free of all others thus moves as in World alone; one pressed down by the
/// gripper settles within some steps, since the share beta < 1 of a wrong guess is left after each.
class WorldEngine {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;

  /// @pre validate(scene), scene.physics.engine is not native. @throws geometry::InputError when
  /// it is not installed.
  explicit WorldEngine(const Scene& scene);
  ~WorldEngine();

  /// Takes these objects as they are: boxes, cans and balls that pads feel as such, others in
  /// convex pieces (surface::convex_pieces); mass, centre and inertia are the model's. @throws
  /// geometry::InputError for an object that the engine cannot have, or a solver that it does not
  /// have.
  void load(const std::vector<BodyModel>& models, const std::vector<BodyState>& bodies);
  /// Tries what load() would, in an engine of its own, so that a world is left as it is when the
  /// last object, which is new, cannot be. @throws as load.
  void require_possible(const std::vector<BodyModel>& models, const std::vector<BodyState>& bodies);

  /// The pieces of an object that is loaded; null: it is a box, can or ball.
  struct Pieces {
    std::shared_ptr<const std::vector<geometry::TriangleMesh>> meshes_B;
    double concavity = 0;  // m, that they reach beyond the mesh at most
  };
  const Pieces* pieces(const BodyModel& model) const;

  /// One step of the scene's length under `wrenches` (force, torque about the centre of mass,
  /// world), of which fixed bodies' do not matter.
  void step(const std::vector<Vector6>& wrenches, const std::vector<BodyModel>& models,
            std::vector<BodyState>& bodies);
  /// Force and torque of the engine's own contacts on a body in the last step, world.
  const Vector6& reaction(std::size_t body) const { return reactions_[body]; }
  std::string version() const;

 private:
  void make_pieces(const BodyModel& model);
  engines::EngineScene scene_of(const std::vector<BodyModel>& models,
                                const std::vector<BodyState>& bodies) const;
  engines::EngineBody engine_body(const BodyModel& model, const BodyState& state) const;

  double step_, gravity_, table_friction_;
  std::string name_, solver_;
  std::unique_ptr<engines::Engine> engine_;
  std::map<std::uint32_t, Pieces> pieces_;  // by BodyModel::id
  std::vector<Eigen::Matrix3d> R_BC_;       // from the engine's frame of each body
  std::vector<Vector6> reactions_;
};

}  // namespace prehend::simulation
