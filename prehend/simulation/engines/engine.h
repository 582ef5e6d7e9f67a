#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_layout.h"
#include "prehend/contact/texel_law.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::contact {
class Shape;
}

/// Physics engines behind one interface: prehend's own and others as plug-ins. A plug-in includes
/// this header only; engines/README.md is the recipe.
namespace prehend::simulation::engines {

using Vector6 = Eigen::Matrix<double, 6, 1>;  // force [N], torque [N m] about the centre of mass

struct EngineShape {
  enum class Kind { kBox, kSphere, kCylinder, kCapsule, kConvexPieces };
  Kind kind = Kind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Constant(0.05);  // m, full sides of a box
  double radius = 0.025;                                   // m
  double length = 0.05;                                    // m, along z; capsule: between centres
  /// Of kConvexPieces: closed convex meshes that make up the shape; they may overlap.
  std::shared_ptr<const std::vector<geometry::TriangleMesh>> pieces;
};

/// A rigid body; frame B has the centre of mass as origin.
struct EngineBody {
  std::string name;
  EngineShape shape;
  geometry::RigidTransform X_BS = geometry::RigidTransform::Identity();  // where the shape is
  /// What pads feel in place of `shape`, in the same frame; null: `shape`. Of `native` only.
  std::shared_ptr<const contact::Shape> felt;
  double mass = 0.1;  // kg
  /// Principal moments along B's axes [kg m^2]; zero: those of the homogeneous shape, which pieces
  /// do not tell.
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();
  double friction = 0.8;  // Coulomb, with every other body; of two the smaller counts
  bool is_fixed = false;
  bool collides = true;  // otherwise it passes through everything
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();  // at the start
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();                    // m/s, at the start
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();            // rad/s, world
};

/// Joins `body` to `parent` (-1: the world). Position 0 is the start. At most one joint for a body;
/// parents stand before their children.
struct EngineJoint {
  enum class Kind { kPrismatic, kRevolute };
  Kind kind = Kind::kPrismatic;
  int parent = -1;
  int body = 0;
  Eigen::Vector3d axis_W = Eigen::Vector3d::UnitX();   // unit, at the start
  Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();  // m, at the start; of kRevolute
  /// Moves by `ratio` times an earlier joint (-1: moves by itself), as coupled jaws do.
  int follows = -1;
  double ratio = 1;
};

/// A tactile pad on a body. X_BP: see contact::PadLayout for frame P. Bodies with pads touch others
/// by their pads alone.
struct EnginePad {
  int body = 0;
  geometry::RigidTransform X_BP = geometry::RigidTransform::Identity();
  contact::PadLayout layout = contact::PadLayout::flat({});
  contact::TexelLaw law;
};

enum class PadMethod {
  kTexelLaw,    // EnginePad::law: coupled implicitly by `native`, by sub-steps on other engines
  kOwnContacts  // the engine's own contact at each texel; the law is left aside
};

struct EngineScene {
  double step = 1e-3;                    // s
  Eigen::Vector3d gravity{0, 0, -9.81};  // m/s^2
  bool ground = false;                   // the plane z = 0
  double ground_friction = 0.8;
  /// One of the engine's solvers(); empty: its first.
  std::string solver;
  std::vector<EngineBody> bodies;
  std::vector<EngineJoint> joints;
  std::vector<EnginePad> pads;
  PadMethod pad_method = PadMethod::kTexelLaw;
};

struct BodyMotion {
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s, of the centre of mass
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, world
};

/// The scene is sound but this engine cannot do it: says what and why.
class UnsupportedScene : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One engine with one scene. Not thread-safe. Same scene and same calls give the same states.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;     // as in scene files
  virtual std::string version() const = 0;  // of the engine
  virtual std::vector<std::string> solvers() const = 0;

  /// Takes a checked scene; a former one is dropped. Pads by the texel law need not be done by a
  /// plug-in: EngineRegistry adds them (substepped_pads.h). @throws UnsupportedScene.
  virtual void load(const EngineScene& scene) = 0;
  /// Advances by scene.step.
  virtual void step() = 0;
  /// Held until changed. Indices are those of the scene.
  virtual void set_joint_force(int joint, double force) = 0;  // N or N m
  virtual void set_body_wrench(int body, const Vector6& wrench_W) = 0;

  virtual BodyMotion body(int index) const = 0;
  virtual double joint_position(int joint) const = 0;  // m or rad
  /// Normal forces of a pad's texels in the last step [N], row by row. @throws UnsupportedScene
  /// where the engine has no pads of its own.
  virtual std::vector<double> pad_forces(int pad) const;

  /// The state as numbers; restoring it in an engine of the same scene continues the same way.
  virtual std::vector<double> save() const = 0;
  virtual void restore(const std::vector<double>& state) = 0;
};

inline std::vector<double> Engine::pad_forces(int) const {
  throw UnsupportedScene(name() + ": has no pads of its own");
}

/// Refuses what only few engines can do. @throws UnsupportedScene for joints that follow others.
inline void refuse_couplings(const EngineScene& scene, const std::string& engine) {
  for (const EngineJoint& joint : scene.joints) {
    if (joint.follows >= 0) throw UnsupportedScene(engine + ": joints cannot follow others");
  }
}

/// @throws UnsupportedScene for pads and for joints that follow others.
inline void refuse_pads_and_couplings(const EngineScene& scene, const std::string& engine) {
  if (!scene.pads.empty()) throw UnsupportedScene(engine + ": has no pads of its own");
  refuse_couplings(scene, engine);
}

/// Checks a scene. @throws std::invalid_argument naming body or joint and field.
void validate(const EngineScene& scene);

// What a plug-in exports, extern "C": prehend_engine_interface() returns kEngineInterface, and
// prehend_create_engine() a new Engine.
constexpr int kEngineInterface = 5;

}  // namespace prehend::simulation::engines
