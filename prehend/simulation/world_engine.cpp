#include "prehend/simulation/world_engine.h"

#include <algorithm>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/text/nearest_match.h"

namespace prehend::simulation {
namespace {

// What prehend brings a plug-in for, and the packages that it needs.
struct Shipped {
  const char* name;
  const char* packages;
};
constexpr Shipped kShipped[] = {{"bullet", "libbullet-dev"},
                                {"dart", "libdart-dev and libdart-collision-ode-dev"},
                                {"mujoco", "libmujoco-dev"},
                                {"ode", "libode-dev"}};

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

engines::EngineBody engine_body(const BodyModel& model, const BodyState& state) {
  engines::EngineBody body;
  body.name = model.name;
  const contact::Shape& shape = model.felt.shape;
  using Kind = engines::EngineShape::Kind;
  body.shape.kind = shape.kind() == contact::Shape::Kind::kBox      ? Kind::kBox
                    : shape.kind() == contact::Shape::Kind::kSphere ? Kind::kSphere
                                                                    : Kind::kCylinder;
  if (body.shape.kind == Kind::kBox) body.shape.size = 2 * shape.half_size();
  if (body.shape.kind != Kind::kBox) body.shape.radius = shape.radius();
  if (body.shape.kind == Kind::kCylinder) body.shape.length = 2 * shape.half_length();
  body.mass = model.mass;
  body.moments = model.inertia.diagonal();
  body.friction = model.pad_law.dynamic_friction;
  body.is_fixed = model.is_static;
  body.X_WB.linear() = state.q_WB.toRotationMatrix();
  body.X_WB.translation() = state.p_WBcm;
  body.velocity = state.velocity;
  body.angular_velocity = state.angular_velocity;
  return body;
}

Eigen::Vector3d angular_momentum(const BodyModel& model, const BodyState& body) {
  const Eigen::Matrix3d R = body.q_WB.toRotationMatrix();
  return R * (model.inertia * (R.transpose() * body.angular_velocity));
}

}  // namespace

std::optional<EngineTrouble> engine_trouble(const std::string& name) {
  if (name == "native") return std::nullopt;
  const engines::EngineRegistry registry;
  if (registry.has(name)) return std::nullopt;
  const std::vector<std::string> installed = registry.names();
  std::vector<std::string> known = installed;
  for (const Shipped& shipped : kShipped) {
    known.emplace_back(shipped.name);
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

void WorldEngine::require_primitive(const BodyModel& model, const std::string& engine) {
  using Kind = contact::Shape::Kind;
  const Kind kind = model.felt.shape.kind();
  if (kind == Kind::kBox || kind == Kind::kSphere || kind == Kind::kCylinder) return;
  throw geometry::InputError(
      "object '" + model.name + "' is a mesh, which engine '" + engine + "' cannot have here",
      "Take boxes, cans and balls, or engine: native");
}

void WorldEngine::load(const std::vector<BodyModel>& models, const std::vector<BodyState>& bodies) {
  engines::EngineScene scene;
  scene.step = step_;
  scene.gravity = {0, 0, -gravity_};
  scene.ground = true;
  scene.ground_friction = table_friction_;
  scene.solver = solver_;
  for (std::size_t i = 0; i < models.size(); ++i) {
    require_primitive(models[i], name_);
    scene.bodies.push_back(engine_body(models[i], bodies[i]));
  }
  reactions_.assign(models.size(), Vector6::Zero());
  engines::validate(scene);
  try {
    engine_->load(scene);
  } catch (const engines::UnsupportedScene& reason) {
    throw geometry::InputError(reason.what(), "Change the scene or take engine: native");
  }
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
    body.q_WB = Eigen::Quaterniond(motion.X_WB.linear()).normalized();
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
