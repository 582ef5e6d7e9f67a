#include "prehend/simulation/robot_world.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/contact/require.h"
#include "prehend/contact/rotation.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/robot_scene.h"
#include "prehend/simulation/robot_world_implementation.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;

constexpr double kStill = 1e-3;         // m/s and rad/s
constexpr double kContactTime = 0.005;  // s that a force must last: jerks of what is held do not

void check(const RobotWorldOptions& options) {
  contact::require_positive(options.step, "RobotWorldOptions::step");
  contact::require(std::isfinite(options.gravity), "RobotWorldOptions::gravity", "finite");
  contact::require_not_negative(options.table_friction, "RobotWorldOptions::table_friction");
}

RobotWorldOptions with_scene(RobotWorldOptions options, const Scene& scene) {
  options.step = scene.step;
  options.gravity = scene.gravity;
  options.table_friction = scene.table.friction;
  options.tactile = scene.tactile;
  options.wrench = scene.wrench;
  options.sleep = options.sleep && scene.physics.rules.sleep;
  options.primitives = options.primitives && scene.physics.rules.primitives;
  return options;
}

// The root of `model` when link `base` is at X_WB.
RigidTransform root_of(const robot::RobotModel& model, const std::string& base,
                       const RigidTransform& X_WB) {
  RigidTransform X_WR = X_WB;
  int link = model.link_index(base);
  while (const auto above = model.joint_above(link)) {
    const robot::Joint& joint = model.joints[static_cast<std::size_t>(*above)];
    X_WR = X_WR * joint.pose_at(0).inverse();
    link = joint.parent;
  }
  return X_WR;
}

}  // namespace

RobotWorld::Implementation::Implementation(const robot::RobotModel& model,
                                           const robot::HandModel& hand_of,
                                           const std::string& prefix_of,
                                           const RigidTransform& X_WRoot,
                                           std::optional<ArmDrive> arm_of,
                                           const RobotWorldOptions& options_of)
    : options(options_of),
      hand_model(hand_of),
      prefix(prefix_of),
      arm(std::move(arm_of)),
      X_WR(X_WRoot),
      sensors(hand_of, options_of.tactile, options_of.wrench) {
  check(options);
  all.setZero(static_cast<Eigen::Index>(model.joints.size()));
  if (arm) {
    for (const robot::ChainJoint& joint : arm->chain().joints()) {
      arm_joints.push_back(model.joint_index(joint.name));
    }
    set_arm_positions();
  }
  robot = make_robot_bodies(model, hand_model, prefix, X_WR, all, options.mechanics);
  for (const RobotBodies::Motor& motor : robot.motors) motor_names.push_back(motor.name);
  hand.emplace(robot, options.hand);
  hand->put_mechanics(robot.mechanics);
  build();
}

void RobotWorld::Implementation::set_arm_positions() {
  for (std::size_t i = 0; i < arm_joints.size(); ++i) {
    all[arm_joints[i]] = arm->position()[static_cast<Eigen::Index>(i)];
  }
}

// The system of robot and objects. What the former system had of them is kept, but touches.
void RobotWorld::Implementation::build() {
  const std::size_t robot_bodies = robot.bodies.size();
  const bool first = !system;
  engines::EngineScene scene;
  scene.step = options.step;
  scene.gravity = {0, 0, -options.gravity};
  scene.ground = true;
  scene.ground_friction = options.table_friction;
  scene.bodies = robot.bodies;
  scene.joints = robot.joints;
  for (engines::EngineBody& body : scene.bodies) body.collides = false;  // RobotTouch meets them
  for (const RobotBodies::Pad& pad : robot.pads) {
    const robot::HandPad& model = hand_model.pads[static_cast<std::size_t>(pad.pad)];
    scene.pads.push_back(
        {pad.body, pad.X_BP, *model.layout, options.tactile.law_of(model.model, pad.pad)});
  }
  std::vector<RobotTouch::Object> touched;
  for (Thing& thing : things) {
    thing.body = static_cast<int>(scene.bodies.size());
    engines::EngineBody body;
    body.name = thing.model.name;
    body.mass = thing.model.mass;
    body.moments = thing.moments;
    body.friction = thing.friction;
    body.is_fixed = thing.model.is_static;
    body.X_WB = thing.motion.X_WB;
    body.velocity = thing.motion.velocity;
    body.angular_velocity = thing.motion.angular_velocity;
    body.shape.kind = engines::EngineShape::Kind::kSphere;
    body.shape.radius = thing.model.radius;
    body.felt = std::make_shared<contact::Shape>(thing.model.felt.shape);
    body.X_BS = thing.X_CB * thing.model.felt.X_BS;
    scene.bodies.push_back(body);
    touched.push_back({thing.body, thing.model, thing.X_CB});
  }
  engines::validate(scene);
  touch = std::make_unique<RobotTouch>(robot, hand_model.pads, std::move(touched));
  system = std::make_unique<engines::Multibody>(scene);
  system->set_contact_stiffness(options.contact_stiffness, options.contact_damping);
  system->set_ground_stiffness(options.table_stiffness, options.table_damping);
  system->set_touch_finder(touch.get());
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (robot.joints[j].follows < 0) {
      system->set_mechanics(static_cast<int>(j), robot.mechanics[j]);
    }
  }
  for (const engines::JointCoupling& coupling : robot.couplings) system->add_coupling(coupling);
  engines::MultibodyState fresh = system->initial_state();
  if (!first) {
    const Eigen::Index joints = fresh.positions.size();
    fresh.time = state.time;
    fresh.positions = state.positions;
    fresh.velocities.head(joints) = state.velocities.head(joints);
    for (std::size_t b = 0; b < robot_bodies; ++b) fresh.X_WB[b] = state.X_WB[b];
    system->complete(fresh);
  }
  state = fresh;
  next = fresh;
  for (const Thing& thing : things) {
    if (thing.asleep && !thing.model.is_static) system->set_asleep(thing.body, true);
  }
  ++generation;
}

void RobotWorld::Implementation::read_motions() {
  for (Thing& thing : things) {
    if (thing.body >= 0) thing.motion = system->motion(state, thing.body);
  }
}

void RobotWorld::Implementation::add(BodyModel model, double friction, const RigidTransform& X_WB) {
  read_motions();
  Thing thing;
  const PrincipalAxes axes = principal_axes(model);
  thing.moments = axes.moments;
  thing.X_CB = axes.X_BC.inverse(Eigen::Isometry);
  thing.motion.X_WB = X_WB * axes.X_BC;
  thing.friction = friction;
  thing.model = std::move(model);
  const auto same = std::find_if(things.begin(), things.end(), [&](const Thing& other) {
    return other.model.name == thing.model.name;
  });
  if (same != things.end()) {
    *same = std::move(thing);
  } else {
    things.push_back(std::move(thing));
  }
}

void RobotWorld::Implementation::move_carried() {
  if (arm) {
    if (arm->is_idle()) return;
    arm->step(options.step);
    set_arm_positions();
  } else {
    if (!path) return;
    path->time = std::min(path->duration, path->time + options.step);
    const double s = path->time / path->duration;
    const double share = s * s * s * (10 + s * (-15 + 6 * s));
    X_WR.translation() = (1 - share) * path->from.translation() + share * path->to.translation();
    const Eigen::Quaterniond from(path->from.linear()), to(path->to.linear());
    X_WR.linear() = from.slerp(share, to).normalized().toRotationMatrix();
    if (s >= 1) {
      X_WR = path->to;
      path.reset();
    }
  }
  prescribe_carried();
}

void RobotWorld::Implementation::prescribe_carried() {
  robot.link_poses(X_WR, all, link_poses);
  for (const RobotBodies::Carried& carried : robot.carried) {
    system->prescribe(carried.body, link_poses[static_cast<std::size_t>(carried.link)]);
  }
}

void RobotWorld::Implementation::put_to_sleep() {
  if (!options.sleep) return;
  for (Thing& thing : things) {
    if (thing.model.is_static) continue;
    bool robot_touches = false, mover_touches = false, stands = false;
    for (const engines::TouchPoint& touch_point : state.touches) {
      if (touch_point.a != thing.body && touch_point.b != thing.body) continue;
      const int other = touch_point.a == thing.body ? touch_point.b : touch_point.a;
      if (other < 0) {
        stands = stands || touch_point.normal_force > 0;
        continue;
      }
      const bool is_robot = other < static_cast<int>(robot.bodies.size());
      robot_touches = robot_touches || is_robot;
      if (!is_robot) {
        const engines::BodyMotion motion = system->motion(state, other);
        mover_touches = mover_touches || motion.velocity.norm() > kStill;
      }
    }
    robot_touches = robot_touches || pad_normal_force(thing.body) > 0;
    const engines::BodyMotion motion = system->motion(state, thing.body);
    const bool still = motion.velocity.norm() < kStill &&
                       motion.angular_velocity.norm() * thing.model.radius < kStill;
    const bool disturbed = robot_touches || mover_touches;
    thing.still_time = still && !disturbed ? thing.still_time + options.step : 0.0;
    const bool asleep = thing.asleep ? !disturbed : stands && thing.still_time > kStillTime;
    if (asleep != thing.asleep) {
      thing.asleep = asleep;
      system->set_asleep(thing.body, asleep);
    }
  }
}

void RobotWorld::Implementation::step() {
  move_carried();
  hand->before_step(options.step, *system, state);
  system->implicit_euler(state, options.step, state, next);
  std::swap(state, next);
  hand->after_step(options.step, *system, state);
  put_to_sleep();
  read_sensors();
  const bool above = contact_limit > 0 && arm && wrist.force.norm() > contact_limit;
  contact_time = above ? contact_time + options.step : 0;
  if (contact_time >= kContactTime) {
    arm->stop();
    contact = true;
    contact_limit = 0;
  }
}

RobotWorld::RobotWorld(const robot::Platform& platform, const Scene& scene, const std::string& home,
                       const RobotWorldOptions& options) {
  check_for_robot(scene, platform);
  const robot::Platform::Home& start = platform.home(home);
  implementation_ = std::make_unique<Implementation>(
      platform.model, platform.hand, "hand_", root_of(platform.model, platform.base, platform.X_WB),
      ArmDrive(platform.arm_chain(), start.arm, options.arm), with_scene(options, scene));
  Implementation& world = *implementation_;
  for (const SceneObject& object : scene.objects) {
    const auto primitive =
        world.options.primitives ? primitive_shape(object) : std::optional<FeltShape>();
    BodyModel model = make_body(object.name, object_mesh(object), object.mass, object.friction,
                                scene.table.friction, {}, primitive ? &*primitive : nullptr);
    model.texture = object.texture;
    world.add(std::move(model), object.friction, object.pose());
  }
  world.build();
  set_hand(platform.hand.preshapes.front().open);
}

RobotWorld::RobotWorld(const robot::HandModel& hand, const RigidTransform& X_WH,
                       const std::string& preshape, const RobotWorldOptions& options)
    : implementation_(
          std::make_unique<Implementation>(hand.model, hand, "", X_WH, std::nullopt, options)) {
  set_hand(preshape.empty() ? hand.preshapes.front().open : hand.preshape(preshape).open);
}

RobotWorld::~RobotWorld() = default;
RobotWorld::RobotWorld(RobotWorld&&) noexcept = default;
RobotWorld& RobotWorld::operator=(RobotWorld&&) noexcept = default;

void RobotWorld::step() { implementation_->step(); }
double RobotWorld::time() const { return implementation_->state.time; }
const RobotWorldOptions& RobotWorld::options() const { return implementation_->options; }
const robot::HandModel& RobotWorld::hand_model() const { return implementation_->hand_model; }
bool RobotWorld::has_arm() const { return implementation_->arm.has_value(); }

ArmDrive& RobotWorld::arm() {
  if (!implementation_->arm) throw std::logic_error("this world has a hand without an arm");
  return *implementation_->arm;
}
const ArmDrive& RobotWorld::arm() const { return const_cast<RobotWorld*>(this)->arm(); }

void RobotWorld::follow(const TrajectoryRequest& request, const std::vector<double>& tolerance) {
  ArmDrive& drive = arm();
  drive.follow(
      check_trajectory(drive.chain(), request, drive.position(), implementation_->options.arm),
      tolerance);
  implementation_->contact = false;
  implementation_->contact_limit = 0;
}

void RobotWorld::stop_on_contact(double force) {
  contact::require_not_negative(force, "contact_force");
  implementation_->contact_limit = force;
  implementation_->contact_time = 0;
  implementation_->contact = false;
}
bool RobotWorld::stopped_by_contact() const { return implementation_->contact; }

void RobotWorld::carry(const RigidTransform& X_WH, double duration) {
  if (has_arm()) throw std::logic_error("this hand is carried by its arm");
  contact::require(X_WH.matrix().allFinite(), "X_WH", "finite");
  contact::require_positive(duration, "duration");
  implementation_->path = Implementation::Path{};  // not emplace(): clang would not have it
  Implementation::Path& path = *implementation_->path;
  path.from = implementation_->X_WR;
  path.to = X_WH;
  path.duration = std::max(duration, implementation_->options.step);
}
bool RobotWorld::carried() const { return !implementation_->path.has_value(); }

void RobotWorld::set_carrier(const RigidTransform& X_WH) {
  if (has_arm()) throw std::logic_error("this hand is carried by its arm");
  contact::require(X_WH.matrix().allFinite(), "X_WH", "finite");
  Implementation& world = *implementation_;
  world.path.reset();
  world.X_WR = X_WH;
  world.prescribe_carried();
  for (const RobotBodies::Carried& carried : world.robot.carried) {
    world.state.X_WB[static_cast<std::size_t>(carried.body)] =
        world.link_poses[static_cast<std::size_t>(carried.link)];
  }
  world.state.velocities.head(world.state.positions.size()).setZero();
  world.system->complete(world.state);
  stop_hand();
}

const std::vector<std::string>& RobotWorld::motor_names() const {
  return implementation_->motor_names;
}
HandDrive& RobotWorld::hand() { return *implementation_->hand; }
const HandDrive& RobotWorld::hand() const { return *implementation_->hand; }
Eigen::VectorXd RobotWorld::hand_positions() const {
  return implementation_->hand->positions(implementation_->state);
}
void RobotWorld::move_hand(const HandCommand& command) { implementation_->hand->move(command); }
void RobotWorld::command_hand(const MotorsCommand& command) {
  implementation_->hand->command(command);
}
bool RobotWorld::stop_commanded_hand() {
  return implementation_->hand->stop_commanded(implementation_->state);
}
void RobotWorld::stop_hand() { implementation_->hand->hold(implementation_->state); }

void RobotWorld::set_hand(const Eigen::VectorXd& positions) {
  Implementation& world = *implementation_;
  contact::require(positions.allFinite(), "the hand's positions", "finite");
  const Eigen::VectorXd hand_all = world.hand_model.all_positions(positions);
  for (std::size_t j = 0; j < world.robot.model.joints.size(); ++j) {
    const int engine = world.robot.engine_joint[j];
    if (engine < 0 || world.robot.joints[static_cast<std::size_t>(engine)].follows >= 0) continue;
    const std::string own = world.robot.model.joints[j].name.substr(world.prefix.size());
    const int c = world.robot.coordinate[static_cast<std::size_t>(engine)];
    world.state.positions[c] = hand_all[world.hand_model.model.joint_index(own)];
    world.state.velocities[c] = 0;
  }
  world.system->complete(world.state);
  world.hand->begin(world.state);
}

void RobotWorld::add_object(const std::string& name, const geometry::TriangleMesh& mesh_W,
                            double mass, bool is_static, double friction, const Texture& texture) {
  if (mesh_W.vertices.empty()) {
    throw geometry::InputError("the mesh of object '" + name + "' is empty", "Give it triangles");
  }
  const Eigen::AlignedBox3d box = geometry::bounds(mesh_W);
  RigidTransform X_WB = RigidTransform::Identity();
  X_WB.translation() = box.center();
  BodyModel model = make_body(name, geometry::transformed(mesh_W, X_WB.inverse(Eigen::Isometry)),
                              mass, friction, implementation_->options.table_friction, {});
  model.is_static = is_static;
  model.texture = texture;
  if (box.min().z() < 0) X_WB.translation().z() -= box.min().z();
  implementation_->add(std::move(model), friction, X_WB);
  implementation_->build();
}

bool RobotWorld::remove_object(const std::string& name) {
  auto& things = implementation_->things;
  const auto found = std::find_if(things.begin(), things.end(),
                                  [&](const auto& thing) { return thing.model.name == name; });
  if (found == things.end()) return false;
  implementation_->read_motions();
  things.erase(found);
  implementation_->build();
  return true;
}

void RobotWorld::place_object(const std::string& name, const RigidTransform& X_WB) {
  implementation_->read_motions();
  Implementation::Thing& thing = implementation_->thing(name);
  thing.motion = {};
  thing.motion.X_WB = X_WB * thing.X_CB.inverse(Eigen::Isometry);
  thing.asleep = false;
  thing.still_time = 0;
  implementation_->build();
}

std::uint64_t RobotWorld::scene_generation() const { return implementation_->generation; }

}  // namespace prehend::simulation
