#include "prehend/simulation/world.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {

using geometry::RigidTransform;

namespace {

// Frame P of a pad: z out of it, y along the finger to the tip, where row 0 is.
contact::PadMount mount_of(const Scene& scene, int pad) {
  const robot::GripperModel& gripper = scene.gripper;
  const double side = pad == 0 ? 1 : -1;
  contact::PadGrid grid;
  grid.rows = gripper.pad.rows;
  grid.columns = gripper.pad.columns;
  grid.width = gripper.pad.width();
  grid.length = gripper.pad.length();
  grid.thickness = gripper.pad.thickness;
  contact::PadMount mount{
      contact::PadLayout::flat(grid), scene.tactile.law_of(gripper.pad, pad), {}, 0, {}};
  mount.X_GP = RigidTransform::Identity();
  mount.X_GP.linear().col(0) = Eigen::Vector3d(side, 0, 0);
  mount.X_GP.linear().col(1) = Eigen::Vector3d::UnitZ();
  mount.X_GP.linear().col(2) = Eigen::Vector3d(0, -side, 0);
  mount.direction_G = Eigen::Vector3d(0, -0.5 * side, 0);
  return mount;
}

// The right pad's x axis runs against the gripper's, as frames show it and were calibrated.
PadElectronics electronics_of(const Scene& scene, int pad) {
  TactileOptions tactile = scene.tactile;
  const int columns = scene.gripper.pad.columns;
  for (robot::PadCalibration& calibration : tactile.calibrations) {
    for (auto* values : {&calibration.gains, &calibration.zeros}) {
      for (auto row = values->begin(); pad == 1 && row != values->end(); row += columns) {
        if (values->end() - row < columns) break;
        std::reverse(row, row + columns);
      }
    }
  }
  return {tactile, scene.gripper.pad, pad};
}

}  // namespace

World::Implementation::Implementation(const Scene& scene_in)
    : scene(scene_in),
      state{0,
            {},
            {},
            Carrier(scene_in.carrier),
            GripperAxis(scene_in.gripper, scene_in.drive),
            {electronics_of(scene_in, 0), electronics_of(scene_in, 1)},
            {},
            0,
            {},
            {},
            scene_in.physics.adaptive ? scene_in.step : 0.0},
      mounts{mount_of(scene_in, 0), mount_of(scene_in, 1)},
      reaches{contact::PadReach(mounts[0].layout), contact::PadReach(mounts[1].layout)},
      slide_model(state.gripper.slide()),
      slide_step(slide_model),
      solver(scene_in.physics.velocity_tolerance, scene_in.physics.most_iterations) {
  if (scene.wrench) state.wrist.emplace(*scene.wrench);
  if (scene.physics.engine != "native") engine = std::make_unique<WorldEngine>(scene);
  state.motion.slide = -scene.start_opening;
  for (const GripperBox& part : gripper_boxes(scene.gripper, scene.gripper.max_opening)) {
    gripper_radius = std::max(
        gripper_radius, part.box_G.min().cwiseAbs().cwiseMax(part.box_G.max().cwiseAbs()).norm());
  }
  make_gripper_meshes();
  for (int pad : {0, 1})
    state.frames[pad] = image(pad, state.pads[pad].sample(texel_forces(pad), 0));
}

void World::Implementation::make_gripper_meshes() {
  const auto share = [](const Eigen::Vector3d& size) {
    return std::make_shared<const geometry::TriangleMesh>(geometry::make_box(size));
  };
  const auto boxes = gripper_boxes(scene.gripper, 0);
  finger_mesh = share(boxes[0].box_G.sizes());
  housing_mesh = share(boxes[2].box_G.sizes());
  const robot::TactilePadModel& pad = scene.gripper.pad;
  pad_mesh = share({pad.width(), pad.thickness, pad.length()});
}

GripperPlacement World::Implementation::placement() const {
  return {state.carrier.pose(), state.carrier.velocity(), state.carrier.yaw_rate(), opening()};
}

int World::Implementation::index_of(const std::string& name) const {
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (models[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

int World::Implementation::index_or_throw(const std::string& name) const {
  const int index = index_of(name);
  if (index < 0) throw std::invalid_argument("there is no object '" + name + "'");
  return index;
}

// All bodies, but for those that the gripper can never touch and that stand as they are.
void World::Implementation::wake_all() {
  constexpr double kMargin = 1e-3;  // m, of the centre of mass over what carries it
  for (std::size_t i = 0; i < models.size(); ++i) {
    BodyState& body = state.motion.bodies[i];
    body.still_time = 0;
    const bool at_rest = body.velocity.isZero(0) && body.angular_velocity.isZero(0);
    body.asleep = !engine && scene.physics.rules.out_of_reach && at_rest && !models[i].is_static &&
                  !in_reach(static_cast<int>(i)) && stands_stably(models[i], body, kMargin);
    if (body.asleep) body.touches_table = true;
  }
}

// Whether the gripper can come to touch the body where it is.
bool World::Implementation::in_reach(int i) const {
  Eigen::AlignedBox3d swept(scene.carrier.minimum, scene.carrier.maximum);
  swept.min().array() -= gripper_radius;
  swept.max().array() += gripper_radius;
  const RigidTransform X_WB = body_pose(models[i], state.motion.bodies[i]);
  return swept.intersects(transformed_box(X_WB, models[i].box));
}

BodyModel World::Implementation::make_model(const std::string& name,
                                            const geometry::TriangleMesh& mesh_B, double mass,
                                            double friction,
                                            const std::optional<FeltShape>& felt) const {
  const bool as_primitive = felt && scene.physics.rules.primitives;
  return make_body(name, mesh_B, mass, friction, scene.table.friction, scene.gripper.pad.law,
                   as_primitive ? &*felt : nullptr);
}

void World::Implementation::add(BodyModel model, const RigidTransform& X_WB) {
  model.id = next_id++;
  BodyState body;
  set_body_pose(model, X_WB, body);
  state.body_ids.push_back(model.id);
  state.motion.bodies.push_back(body);
  state.motion.touches.push_back(
      {PadTouch(mounts[0].layout, mounts[0].law), PadTouch(mounts[1].layout, mounts[1].law)});
  pad_work.push_back({PadWork(mounts[0], model), PadWork(mounts[1], model)});
  models.push_back(std::move(model));
}

void World::Implementation::require_possible(BodyModel model, const RigidTransform& X_WB,
                                             int replaced) const {
  std::vector<BodyModel> all = models;
  std::vector<BodyState> bodies = state.motion.bodies;
  if (replaced >= 0) {
    all.erase(all.begin() + replaced);
    bodies.erase(bodies.begin() + replaced);
  }
  model.id = next_id;
  set_body_pose(model, X_WB, bodies.emplace_back());
  all.push_back(std::move(model));
  engine->require_possible(all, bodies);
}

void World::Implementation::remove(int index) {
  models.erase(models.begin() + index);
  state.motion.bodies.erase(state.motion.bodies.begin() + index);
  state.motion.touches.erase(state.motion.touches.begin() + index);
  state.body_ids.erase(state.body_ids.begin() + index);
  pad_work.erase(pad_work.begin() + index);
  contacts.clear();
  pads.clear();
  wake_all();
}

bool World::Implementation::moves(int i) const {
  return !models[i].is_static && !state.motion.bodies[i].asleep;
}

World::World(const Scene& scene) {
  validate(scene);
  if (!scene.robot.empty()) {
    throw std::invalid_argument(
        "Scene::robot must be empty: a World has a gripper on a carrier; "
        "arms and hands are for RobotWorld");
  }
  implementation_ = std::make_unique<Implementation>(scene);
  for (const SceneObject& object : scene.objects) {
    BodyModel model = implementation_->make_model(object.name, object_mesh(object), object.mass,
                                                  object.friction, primitive_shape(object));
    model.texture = object.texture;
    implementation_->add(std::move(model), object.pose());
  }
  implementation_->wake_all();
  implementation_->reload_engine();
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

void World::step() { implementation_->step(); }
void World::advance(double duration) {
  const double step = implementation_->scene.step, count = std::round(duration / step);
  if (!(count >= 0 && std::abs(count * step - duration) <= 1e-6 * step)) {
    throw std::invalid_argument("duration must be a whole number of steps of " +
                                std::to_string(step) + " s, not negative");
  }
  const auto ticks = static_cast<std::int64_t>(count);
  advance(ticks, [] { return false; });
}
std::int64_t World::advance(std::int64_t steps, const std::function<bool()>& ends) {
  if (implementation_->scene.physics.adaptive) {
    return implementation_->advance_adaptively(steps, ends);
  }
  for (std::int64_t i = 0; i < steps; ++i) {
    implementation_->step();
    if (ends()) return i + 1;
  }
  return steps;
}
double World::time() const { return implementation_->state.steps * implementation_->scene.step; }
const Scene& World::scene() const { return implementation_->scene; }

void World::set_gripper_command(GripperMode mode, double value, double current_limit,
                                double speed) {
  implementation_->state.gripper.command(mode, value, current_limit, speed);
  WorldCommand command;
  command.mode = mode;
  command.value = value;
  command.current_limit = current_limit;
  command.speed = speed;
  implementation_->record(std::move(command));
}
void World::move_carrier(const RigidTransform& X_WG_target, double speed) {
  implementation_->state.carrier.move(X_WG_target, speed);
  WorldCommand command;
  command.kind = WorldCommand::Kind::kMoveCarrier;
  command.pose = X_WG_target;
  command.speed = speed;
  implementation_->record(std::move(command));
}
void World::drive_carrier(const Eigen::Vector3d& velocity_W, double yaw_rate) {
  implementation_->state.carrier.drive(velocity_W, yaw_rate, scene().step);
  WorldCommand command;
  command.kind = WorldCommand::Kind::kDriveCarrier;
  command.pose.translation() = velocity_W;
  command.value = yaw_rate;
  implementation_->record(std::move(command));
}
void World::guide_carrier(const CarrierPath& path) {
  implementation_->state.carrier.guide(path);
  WorldCommand command;
  command.kind = WorldCommand::Kind::kGuideCarrier;
  command.path = path;
  implementation_->record(std::move(command));
}
void World::stop_carrier() {
  implementation_->state.carrier.stop();
  WorldCommand command;
  command.kind = WorldCommand::Kind::kStopCarrier;
  implementation_->record(std::move(command));
}

GripperReading World::gripper() const {
  const State& state = implementation_->state;
  return {implementation_->opening(), -state.motion.slide_velocity, state.gripper.current(),
          state.gripper.moving(), state.gripper.blocked()};
}

CarrierReading World::carrier() const {
  const Carrier& carrier = implementation_->state.carrier;
  return {carrier.pose(),   carrier.velocity(),  carrier.yaw_rate(),
          carrier.moving(), carrier.remaining(), carrier.yaw()};
}

ContactWrench World::wrist_wrench() const { return implementation_->state.wrench; }
std::size_t World::body_count() const { return implementation_->models.size(); }

BodyReading World::body(std::size_t index) const {
  if (index >= body_count()) throw std::invalid_argument("body index out of range");
  return implementation_->reading(index);
}
BodyReading World::body(const std::string& name) const {
  return implementation_->reading(implementation_->index_or_throw(name));
}

void World::add_object(const std::string& name, const geometry::TriangleMesh& mesh_W, double mass,
                       bool is_static, double friction, const Texture& texture) {
  if (name.empty()) throw std::invalid_argument("an object needs a name");
  // Around its own centre, since ray queries are exact near their frame's origin only.
  const Eigen::AlignedBox3d box = geometry::bounds(mesh_W);
  RigidTransform X_WB = RigidTransform::Identity();
  if (!box.isEmpty()) X_WB.translation() = box.center();
  BodyModel model = implementation_->make_model(name, geometry::transformed(mesh_W, X_WB.inverse()),
                                                mass, friction, std::nullopt);
  model.is_static = is_static;
  model.texture = texture;
  X_WB.translation().z() -= std::min(0.0, box.min().z());
  const int existing = implementation_->index_of(name);
  if (implementation_->engine) implementation_->require_possible(model, X_WB, existing);
  if (existing >= 0) implementation_->remove(existing);
  implementation_->add(std::move(model), X_WB);
  implementation_->wake_all();
  implementation_->reload_engine();
  ++implementation_->generation;
  WorldCommand command;
  command.kind = WorldCommand::Kind::kAddObject;
  command.name = name;
  command.mass = mass;
  command.is_static = is_static;
  command.friction = friction;
  command.texture = texture;
  if (implementation_->records) command.mesh_W = mesh_W;
  implementation_->record(std::move(command));
}

bool World::remove_object(const std::string& name) {
  const int index = implementation_->index_of(name);
  if (index < 0) return false;
  implementation_->remove(index);
  implementation_->reload_engine();
  ++implementation_->generation;
  WorldCommand command;
  command.kind = WorldCommand::Kind::kRemoveObject;
  command.name = name;
  implementation_->record(std::move(command));
  return true;
}

void World::place_object(const std::string& name, const RigidTransform& X_WB) {
  const int index = implementation_->index_or_throw(name);
  if (!X_WB.matrix().allFinite()) throw std::invalid_argument("pose must be finite");
  BodyState body;
  set_body_pose(implementation_->models[index], X_WB, body);
  implementation_->state.motion.bodies[index] = body;
  for (PadTouch& touch : implementation_->state.motion.touches[index]) clear(touch);
  implementation_->wake_all();
  implementation_->reload_engine();
  ++implementation_->generation;
  WorldCommand command;
  command.kind = WorldCommand::Kind::kPlaceObject;
  command.name = name;
  command.pose = X_WB;
  implementation_->record(std::move(command));
}

std::uint64_t World::scene_generation() const { return implementation_->generation; }

}  // namespace prehend::simulation
