#include "prehend/simulation/world_engine.h"

#include <algorithm>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/surface/convex_pieces.h"
#include "prehend/text/nearest_match.h"

namespace prehend::simulation {
namespace {

// What prehend brings a plug-in for, and the packages that it needs.
struct Shipped {
  const char* name;
  const char* packages;
};
constexpr int kMostCorners = 512;     // of a piece
constexpr double kLeastPiece = 1e-6;  // of its extent cubed: thinner ones bear nothing
constexpr Shipped kShipped[] = {{"bullet", "libbullet-dev"},
                                {"dart", "libdart-dev and libdart-collision-ode-dev"},
                                {"mujoco", "libmujoco-dev"},
                                {"ode", "libode-dev"}};

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

// Whether pads feel it, and engines have it, as a primitive.
bool is_primitive(const BodyModel& model) {
  return model.felt.shape.kind() != contact::Shape::Kind::kMesh;
}

void load_into(engines::Engine& engine, const engines::EngineScene& scene) {
  try {
    engine.load(scene);
  } catch (const engines::UnsupportedScene& reason) {
    throw geometry::InputError(reason.what(), "Change the scene or take engine: native");
  }
}

Eigen::Vector3d angular_momentum(const BodyModel& model, const BodyState& body) {
  const Eigen::Matrix3d R = body.q_WB.toRotationMatrix();
  return R * (model.inertia * (R.transpose() * body.angular_velocity));
}

}  // namespace

std::optional<EngineTrouble> engine_trouble(const std::string& name) {
  if (name == "native") return std::nullopt;
  return engine_trouble(name, engines::EngineRegistry());
}

std::optional<EngineTrouble> engine_trouble(const std::string& name,
                                            const engines::EngineRegistry& registry) {
  if (registry.has(name)) return std::nullopt;
  const std::vector<std::string> installed = registry.names();
  std::vector<std::string> known = installed;
  for (const Shipped& shipped : kShipped) {
    if (!registry.has(shipped.name)) known.emplace_back(shipped.name);
    if (name != shipped.name) continue;
    std::string why = "is '" + name + "', whose plug-in is not installed";
    for (const text::PlugInProblem& problem : registry.problems()) {
      if (problem.file.stem() == name) why += " (it cannot be used: " + problem.reason + ")";
    }
    return EngineTrouble{why, std::string("Install ") + shipped.packages +
                                  " and build prehend again, or write one of " + joined(installed)};
  }
  return EngineTrouble{
      "is '" + name + "', which is no engine",
      text::nearest_match_mend(name, known) + ". Installed are " + joined(installed)};
}

WorldEngine::WorldEngine(const Scene& scene)
    : step_(scene.step),
      gravity_(scene.gravity),
      table_friction_(scene.table.friction),
      name_(scene.physics.engine),
      solver_(scene.physics.solver) {
  if (const auto trouble = engine_trouble(name_)) {
    throw geometry::InputError("physics.engine " + trouble->wrong, trouble->mend);
  }
  engine_ = engines::EngineRegistry().create(name_);
}

WorldEngine::~WorldEngine() = default;

std::string WorldEngine::version() const { return engine_->version(); }

const WorldEngine::Pieces* WorldEngine::pieces(const BodyModel& model) const {
  const auto found = pieces_.find(model.id);
  return found == pieces_.end() ? nullptr : &found->second;
}

void WorldEngine::make_pieces(const BodyModel& model) {
  if (is_primitive(model)) return;
  // A scan's bottom is never flat, and what its hull's corners miss it sinks in by.
  surface::ConvexPiecesOptions options;
  options.max_hull_vertices = kMostCorners;
  const surface::ConvexPieces all = surface::convex_pieces(*model.mesh, options);
  std::vector<geometry::TriangleMesh> solid;
  for (const geometry::TriangleMesh& piece : all.pieces) {
    const double extent = geometry::bounds(piece).sizes().maxCoeff();
    if (geometry::mass_properties(piece).volume > kLeastPiece * extent * extent * extent) {
      solid.push_back(piece);
    }
  }
  if (solid.empty()) {
    throw geometry::InputError("object '" + model.name + "' is too thin for engine '" + name_ + "'",
                               "Give it volume, or take engine: native");
  }
  pieces_[model.id] = {
      std::make_shared<const std::vector<geometry::TriangleMesh>>(std::move(solid)), all.concavity};
}

engines::EngineBody WorldEngine::engine_body(const BodyModel& model, const BodyState& state) const {
  engines::EngineBody body;
  body.name = model.name;
  body.mass = model.mass;
  body.friction = model.pad_law.dynamic_friction;
  body.is_fixed = model.is_static;
  body.X_WB.linear() = state.q_WB.toRotationMatrix();
  body.X_WB.translation() = state.p_WBcm;
  body.velocity = state.velocity;
  body.angular_velocity = state.angular_velocity;
  using Kind = engines::EngineShape::Kind;
  if (const Pieces* made = pieces(model)) {
    const PrincipalAxes axes = principal_axes(model);
    body.shape.kind = Kind::kConvexPieces;
    body.shape.pieces = made->meshes_B;
    body.X_BS = axes.X_BC.inverse(Eigen::Isometry);
    body.moments = axes.moments;
    body.X_WB.linear() = body.X_WB.linear() * axes.X_BC.linear();
    return body;
  }
  const contact::Shape& shape = model.felt.shape;
  body.shape.kind = shape.kind() == contact::Shape::Kind::kBox      ? Kind::kBox
                    : shape.kind() == contact::Shape::Kind::kSphere ? Kind::kSphere
                                                                    : Kind::kCylinder;
  if (body.shape.kind == Kind::kBox) body.shape.size = 2 * shape.half_size();
  if (body.shape.kind != Kind::kBox) body.shape.radius = shape.radius();
  if (body.shape.kind == Kind::kCylinder) body.shape.length = 2 * shape.half_length();
  body.moments = model.inertia.diagonal();
  return body;
}

engines::EngineScene WorldEngine::scene_of(const std::vector<BodyModel>& models,
                                           const std::vector<BodyState>& bodies) const {
  engines::EngineScene scene;
  scene.step = step_;
  scene.gravity = {0, 0, -gravity_};
  scene.ground = true;
  scene.ground_friction = table_friction_;
  scene.solver = solver_;
  for (std::size_t i = 0; i < models.size(); ++i) {
    scene.bodies.push_back(engine_body(models[i], bodies[i]));
  }
  engines::validate(scene);
  return scene;
}

void WorldEngine::require_possible(const std::vector<BodyModel>& models,
                                   const std::vector<BodyState>& bodies) {
  pieces_.erase(models.back().id);  // of one that was refused
  make_pieces(models.back());
  load_into(*engines::EngineRegistry().create(name_), scene_of(models, bodies));
}

void WorldEngine::load(const std::vector<BodyModel>& models, const std::vector<BodyState>& bodies) {
  R_BC_.assign(models.size(), Eigen::Matrix3d::Identity());
  std::map<std::uint32_t, Pieces> kept;
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (!pieces(models[i])) make_pieces(models[i]);
    const Pieces* made = pieces(models[i]);
    if (!made) continue;
    kept[models[i].id] = *made;
    R_BC_[i] = principal_axes(models[i]).X_BC.linear();
  }
  pieces_ = std::move(kept);
  reactions_.assign(models.size(), Vector6::Zero());
  load_into(*engine_, scene_of(models, bodies));
}

void WorldEngine::step(const std::vector<Vector6>& wrenches, const std::vector<BodyModel>& models,
                       std::vector<BodyState>& bodies) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!models[i].is_static) engine_->set_body_wrench(static_cast<int>(i), wrenches[i]);
  }
  engine_->step();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (models[i].is_static) continue;
    BodyState& body = bodies[i];
    const Eigen::Vector3d velocity = body.velocity;
    const Eigen::Vector3d momentum = angular_momentum(models[i], body);
    const engines::BodyMotion motion = engine_->body(static_cast<int>(i));
    body.p_WBcm = motion.X_WB.translation();
    body.q_WB = Eigen::Quaterniond(motion.X_WB.linear() * R_BC_[i].transpose()).normalized();
    body.velocity = motion.velocity;
    body.angular_velocity = motion.angular_velocity;
    Vector6& reaction = reactions_[i];
    reaction.head<3>() = models[i].mass / step_ * (body.velocity - velocity);
    reaction[2] += models[i].mass * gravity_;
    reaction.tail<3>() = (angular_momentum(models[i], body) - momentum) / step_;
    reaction -= wrenches[i];
  }
}

}  // namespace prehend::simulation
