#include "prehend/simulation/world.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {

using geometry::RigidTransform;

World::Implementation::Implementation(const Scene& scene_in)
    : scene(scene_in), state{0,
                             {},
                             {},
                             Carrier(scene_in.carrier),
                             GripperDrive(scene_in.gripper, scene_in.start_opening),
                             {},
                             {},
                             {}} {
  const std::size_t texels = scene.gripper.pad.rows * scene.gripper.pad.columns;
  for (PadReading& pad : state.pads) pad.force.assign(texels, 0.0);
  make_gripper_meshes();
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
  return {state.carrier.pose(), state.carrier.velocity(), state.carrier.yaw_rate(),
          state.drive.opening()};
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

void World::Implementation::wake_all() {
  for (BodyState& body : state.bodies) {
    body.asleep = false;
    body.still_time = 0;
  }
}

void World::Implementation::add(BodyModel model, const RigidTransform& X_WB) {
  model.id = next_id++;
  BodyState body;
  set_body_pose(model, X_WB, body);
  state.body_ids.push_back(model.id);
  state.bodies.push_back(body);
  models.push_back(std::move(model));
}

void World::Implementation::remove(int index) {
  models.erase(models.begin() + index);
  state.bodies.erase(state.bodies.begin() + index);
  state.body_ids.erase(state.body_ids.begin() + index);
  contacts.clear();
  wake_all();
}

bool World::Implementation::moves(int i) const {
  return !models[i].is_static && !state.bodies[i].asleep;
}

World::World(const Scene& scene) {
  validate(scene);
  implementation_ = std::make_unique<Implementation>(scene);
  for (const SceneObject& object : scene.objects) {
    RigidTransform X_WB = RigidTransform::Identity();
    X_WB.linear() = Eigen::AngleAxisd(object.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    X_WB.translation() = Eigen::Vector3d(object.x, object.y, 0);
    BodyModel model = make_body(object.name, object_mesh(object), object.mass, object.friction,
                                scene.table.friction, scene.gripper.pad.law);
    model.texture = object.texture;
    implementation_->add(std::move(model), X_WB);
  }
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

void World::step() { implementation_->step(); }
double World::time() const { return implementation_->state.steps * implementation_->scene.step; }
const Scene& World::scene() const { return implementation_->scene; }

void World::set_gripper_command(GripperMode mode, double value, double current_limit,
                                double speed) {
  implementation_->state.drive.command(mode, value, current_limit, speed);
}
void World::move_carrier(const RigidTransform& X_WG_target, double speed) {
  implementation_->state.carrier.move(X_WG_target, speed);
}
void World::stop_carrier() { implementation_->state.carrier.stop(); }

GripperReading World::gripper() const {
  const GripperDrive& drive = implementation_->state.drive;
  return {drive.opening(), drive.velocity(), drive.current(), drive.moving(), drive.blocked()};
}

CarrierReading World::carrier() const {
  const Carrier& carrier = implementation_->state.carrier;
  return {carrier.pose(), carrier.velocity(), carrier.yaw_rate(), carrier.moving(),
          carrier.remaining()};
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
  BodyModel model =
      make_body(name, geometry::transformed(mesh_W, X_WB.inverse()), mass, friction,
                implementation_->scene.table.friction, implementation_->scene.gripper.pad.law);
  model.is_static = is_static;
  model.texture = texture;
  X_WB.translation().z() -= std::min(0.0, box.min().z());
  const int existing = implementation_->index_of(name);
  if (existing >= 0) implementation_->remove(existing);
  implementation_->add(std::move(model), X_WB);
  implementation_->wake_all();
  ++implementation_->generation;
}

bool World::remove_object(const std::string& name) {
  const int index = implementation_->index_of(name);
  if (index < 0) return false;
  implementation_->remove(index);
  ++implementation_->generation;
  return true;
}

void World::place_object(const std::string& name, const RigidTransform& X_WB) {
  const int index = implementation_->index_or_throw(name);
  if (!X_WB.matrix().allFinite()) throw std::invalid_argument("pose must be finite");
  BodyState body;
  set_body_pose(implementation_->models[index], X_WB, body);
  implementation_->wake_all();
  implementation_->state.bodies[index] = body;
  ++implementation_->generation;
}

std::uint64_t World::scene_generation() const { return implementation_->generation; }

std::shared_ptr<const World::State> World::save() const {
  return std::make_shared<const State>(implementation_->state);
}

void World::restore(const State& state) {
  if (state.body_ids != implementation_->state.body_ids) {
    throw std::invalid_argument("the saved state is of other objects than the world's");
  }
  implementation_->state = state;
  implementation_->contacts.clear();
}

}  // namespace prehend::simulation
