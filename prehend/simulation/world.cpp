#include "prehend/simulation/world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/carrier.h"
#include "prehend/simulation/contact_detection.h"
#include "prehend/simulation/contact_solver.h"
#include "prehend/simulation/gripper_drive.h"
#include "prehend/simulation/rigid_body.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;

// A body that touches only the table and has not moved for this long is left out of the system
// until something that moves touches it.
constexpr double kSleepTime = 0.3;     // s
constexpr double kStillSpeed = 2e-4;   // m/s, of any point of the body
constexpr double kTipStiffness = 2e4;  // N/m, of a finger's corner against the table

struct PadReading {
  std::vector<double> force;  // N, rows * columns
};

bool is_pad(std::uint32_t partner) { return partner == kLeftPad || partner == kRightPad; }
bool is_gripper(std::uint32_t partner) { return partner > kTable && partner <= kRightPad; }

}  // namespace

struct World::State {
  std::int64_t steps = 0;
  std::vector<std::uint32_t> body_ids;
  std::vector<BodyState> bodies;
  Carrier carrier;
  GripperDrive drive;
  std::vector<StoredBristle> bristles;  // by key
  std::array<PadReading, 2> pads;
  ContactWrench wrench;  // in G
};

struct World::Implementation {
  Scene scene;
  std::vector<BodyModel> models;
  State state;
  std::uint64_t generation = 1;
  std::uint32_t next_id = 1;
  std::shared_ptr<const geometry::TriangleMesh> finger_mesh, housing_mesh, pad_mesh;
  std::vector<ContactPoint> contacts;  // of the last step

  explicit Implementation(const Scene& scene_in)
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

  void make_gripper_meshes() {
    const auto share = [](const Eigen::Vector3d& size) {
      return std::make_shared<const geometry::TriangleMesh>(geometry::make_box(size));
    };
    const auto boxes = gripper_boxes(scene.gripper, 0);
    finger_mesh = share(boxes[0].box_G.sizes());
    housing_mesh = share(boxes[2].box_G.sizes());
    const robot::TactilePadModel& pad = scene.gripper.pad;
    pad_mesh = share({pad.width(), pad.thickness, pad.length()});
  }

  GripperPlacement placement() const {
    return {state.carrier.pose(), state.carrier.velocity(), state.carrier.yaw_rate(),
            state.drive.opening()};
  }

  int index_of(const std::string& name) const {
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (models[i].name == name) return static_cast<int>(i);
    }
    return -1;
  }

  int index_or_throw(const std::string& name) const {
    const int index = index_of(name);
    if (index < 0) throw std::invalid_argument("there is no object '" + name + "'");
    return index;
  }

  void wake_all() {
    for (BodyState& body : state.bodies) {
      body.asleep = false;
      body.still_time = 0;
    }
  }

  void add(BodyModel model, const RigidTransform& X_WB) {
    model.id = next_id++;
    BodyState body;
    set_body_pose(model, X_WB, body);
    state.body_ids.push_back(model.id);
    state.bodies.push_back(body);
    models.push_back(std::move(model));
  }

  void remove(int index) {
    models.erase(models.begin() + index);
    state.bodies.erase(state.bodies.begin() + index);
    state.body_ids.erase(state.body_ids.begin() + index);
    contacts.clear();
    wake_all();
  }

  // True when body `i` has to be in this step's system.
  bool moves(int i) const { return !models[i].is_static && !state.bodies[i].asleep; }

  void detect() {
    contacts.clear();
    const GripperPlacement gripper = placement();
    const int count = static_cast<int>(models.size());
    for (int i = 0; i < count; ++i) {
      detect_gripper(models[i], state.bodies[i], i, scene.gripper, gripper, contacts);
    }
    for (const ContactPoint& contact : contacts) wake(contact.a);
    // Waking spreads from body to body.
    bool woken = true;
    std::vector<ContactPoint> between;
    while (woken) {
      woken = false;
      between.clear();
      for (int i = 0; i < count; ++i) {
        for (int j = i + 1; j < count; ++j) {
          if (!moves(i) && !moves(j)) continue;
          const std::size_t before = between.size();
          detect_bodies(models[i], state.bodies[i], i, models[j], state.bodies[j], j, between);
          if (between.size() > before) woken = wake(i) || wake(j) || woken;
        }
      }
    }
    contacts.insert(contacts.end(), between.begin(), between.end());
    for (int i = 0; i < count; ++i) {
      if (moves(i)) detect_table(models[i], state.bodies[i], i, scene.step, contacts);
    }
    std::sort(contacts.begin(), contacts.end(),
              [](const ContactPoint& x, const ContactPoint& y) { return x.key < y.key; });
  }

  bool wake(int i) {
    if (!state.bodies[i].asleep) return false;
    state.bodies[i].asleep = false;
    state.bodies[i].still_time = 0;
    return true;
  }

  // Both lists are sorted by key. Pads keep their bristles in their own frame.
  void fetch_bristles(const Eigen::Matrix3d& R_WG) {
    auto stored = state.bristles.begin();
    for (ContactPoint& contact : contacts) {
      while (stored != state.bristles.end() && stored->key < contact.key) ++stored;
      if (stored == state.bristles.end() || stored->key != contact.key) continue;
      const Eigen::Vector3d z =
          is_pad(contact.partner) ? Eigen::Vector3d(R_WG * stored->bristle) : stored->bristle;
      contact.bristle = z - contact.normal.dot(z) * contact.normal;
    }
  }

  void store_bristles(const Eigen::Matrix3d& R_WG) {
    // Sleeping bodies' table contacts are not detected; their bristles wait.
    std::vector<StoredBristle> kept;
    for (const StoredBristle& stored : state.bristles) {
      const auto id = static_cast<std::uint32_t>(stored.key >> 40);
      for (std::size_t i = 0; i < models.size(); ++i) {
        if (models[i].id == id && state.bodies[i].asleep) kept.push_back(stored);
      }
    }
    for (const ContactPoint& contact : contacts) {
      if (contact.bristle.isZero(0)) continue;
      kept.push_back({contact.key, is_pad(contact.partner)
                                       ? Eigen::Vector3d(R_WG.transpose() * contact.bristle)
                                       : contact.bristle});
    }
    std::sort(kept.begin(), kept.end(),
              [](const StoredBristle& x, const StoredBristle& y) { return x.key < y.key; });
    state.bristles = std::move(kept);
  }

  std::vector<SolverBody> solver_bodies() const {
    std::vector<SolverBody> bodies(models.size());
    for (std::size_t i = 0; i < models.size(); ++i) {
      const BodyModel& model = models[i];
      const BodyState& body = state.bodies[i];
      SolverBody& solver_body = bodies[i];
      solver_body.is_free = moves(static_cast<int>(i));
      solver_body.center = body.p_WBcm;
      if (!solver_body.is_free) continue;
      const Eigen::Matrix3d R = body.q_WB.toRotationMatrix();
      solver_body.mass = model.mass;
      solver_body.inertia_W = R * model.inertia * R.transpose();
      solver_body.force = Eigen::Vector3d(0, 0, -scene.gravity * model.mass);
      solver_body.torque =
          -body.angular_velocity.cross(solver_body.inertia_W * body.angular_velocity);
      solver_body.velocity = body.velocity;
      solver_body.angular_velocity = body.angular_velocity;
    }
    return bodies;
  }

  void step() {
    const double h = scene.step;
    state.carrier.begin_step(h);
    state.drive.begin_step(h);
    detect();
    const GripperPlacement gripper = placement();
    fetch_bristles(gripper.X_WG.linear());
    std::vector<SolverBody> bodies = solver_bodies();
    double jaw_velocity = state.drive.velocity();
    solve_contacts(h, state.drive, bodies, contacts, jaw_velocity);
    read_sensors(gripper);
    store_bristles(gripper.X_WG.linear());
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (!bodies[i].is_free) continue;
      state.bodies[i].velocity = bodies[i].velocity;
      state.bodies[i].angular_velocity = bodies[i].angular_velocity;
      integrate(h, state.bodies[i]);
    }
    fall_asleep(h);
    state.drive.end_step(h, jaw_velocity);
    state.carrier.end_step(h);
    ++state.steps;
  }

  void fall_asleep(double h) {
    std::vector<bool> free_standing(models.size(), true);
    for (const ContactPoint& contact : contacts) {
      if (contact.partner != kTable) free_standing[contact.a] = false;
      if (contact.b >= 0) free_standing[contact.b] = false;
    }
    for (std::size_t i = 0; i < models.size(); ++i) {
      BodyState& body = state.bodies[i];
      if (!moves(static_cast<int>(i))) continue;
      const double fastest =
          body.velocity.norm() + body.angular_velocity.norm() * models[i].box.sizes().norm();
      const bool still = free_standing[i] && body.touches_table && fastest < kStillSpeed;
      body.still_time = still ? body.still_time + h : 0.0;
      if (body.still_time < kSleepTime) continue;
      body.asleep = true;
      body.velocity.setZero();
      body.angular_velocity.setZero();
    }
  }

  void read_sensors(const GripperPlacement& gripper) {
    for (PadReading& pad : state.pads) std::fill(pad.force.begin(), pad.force.end(), 0.0);
    for (BodyState& body : state.bodies) {
      body.touches_left_pad = body.touches_right_pad = body.touches_gripper = false;
      if (!body.asleep) body.touches_table = false;
    }
    ContactWrench wrench_W;
    const auto add_to_wrench = [&](const Eigen::Vector3d& force, const Eigen::Vector3d& point) {
      wrench_W.force += force;
      wrench_W.torque += (point - gripper.X_WG.translation()).cross(force);
    };
    for (const ContactPoint& contact : contacts) {
      if (contact.normal_force <= 0) continue;
      BodyState& body = state.bodies[contact.a];
      if (contact.partner == kTable) body.touches_table = true;
      if (contact.partner == kLeftPad) body.touches_left_pad = true;
      if (contact.partner == kRightPad) body.touches_right_pad = true;
      if (is_gripper(contact.partner)) add_to_wrench(-contact.force, contact.point);
      if (is_pad(contact.partner)) {
        state.pads[contact.partner == kLeftPad ? 0 : 1].force[contact.texel] +=
            contact.normal_force;
      } else if (is_gripper(contact.partner)) {
        body.touches_gripper = true;
      }
    }
    for (const GripperBox& part : gripper_boxes(scene.gripper, gripper.opening)) {
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d p =
            gripper.X_WG * part.box_G.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        if (p.z() < 0) add_to_wrench(Eigen::Vector3d(0, 0, -kTipStiffness * p.z()), p);
      }
    }
    const Eigen::Matrix3d R_GW = gripper.X_WG.linear().transpose();
    state.wrench = {R_GW * wrench_W.force, R_GW * wrench_W.torque};
  }

  BodyReading reading(std::size_t i) const {
    const BodyState& body = state.bodies[i];
    BodyReading reading;
    reading.name = models[i].name;
    reading.X_WB = body_pose(models[i], body);
    reading.velocity = body.velocity;
    reading.angular_velocity = body.angular_velocity;
    reading.mass = models[i].mass;
    reading.height = lowest_point(models[i], body);
    reading.touches_left_pad = body.touches_left_pad;
    reading.touches_right_pad = body.touches_right_pad;
    reading.touches_table = body.touches_table;
    reading.touches_gripper = body.touches_gripper;
    return reading;
  }
};

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

TactileImage World::tactile_image(PadSide side) const {
  const robot::TactilePadModel& pad = implementation_->scene.gripper.pad;
  const auto& force = implementation_->state.pads[side == PadSide::kLeft ? 0 : 1].force;
  TactileImage image{pad.rows, pad.columns, {}, 0};
  for (const double f : force) {
    const double counts = std::min<double>(pad.full_scale, std::round(f / pad.newton_per_count));
    image.counts.push_back(static_cast<std::uint16_t>(counts));
    image.sum += f;
  }
  return image;
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

double World::energy() const {
  double sum = 0;
  std::vector<ContactPoint> touching;
  for (std::size_t i = 0; i < body_count(); ++i) {
    const BodyModel& model = implementation_->models[i];
    const BodyState& body = implementation_->state.bodies[i];
    if (model.is_static) continue;
    const Eigen::Vector3d w_B = body.q_WB.conjugate() * body.angular_velocity;
    sum += 0.5 * model.mass * body.velocity.squaredNorm() + 0.5 * w_B.dot(model.inertia * w_B) +
           model.mass * implementation_->scene.gravity * body.p_WBcm.z();
    detect_table(model, body, static_cast<int>(i), 0, touching);
  }
  for (const ContactPoint& contact : touching) {
    sum += 0.5 * contact.law->stiffness * contact.depth * contact.depth;
  }
  return sum;
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

std::vector<VisibleBody> World::visible_bodies() const {
  const Implementation& world = *implementation_;
  std::vector<VisibleBody> bodies;
  for (std::size_t i = 0; i < world.models.size(); ++i) {
    const BodyModel& model = world.models[i];
    bodies.push_back({model.name, model.mesh, body_pose(model, world.state.bodies[i]),
                      model.texture, model.box.max().z()});
  }
  const Texture metal{Texture::Pattern::kNoise, {0.45, 0.47, 0.5}, {0.5, 0.52, 0.55}, 0.1, 0.02, 3};
  const Texture foam{Texture::Pattern::kNoise, {0.1, 0.1, 0.1}, {0.14, 0.14, 0.14}, 0.2, 0.01, 4};
  const GripperPlacement gripper = world.placement();
  for (const GripperBox& part : gripper_boxes(world.scene.gripper, gripper.opening)) {
    RigidTransform X_GP = RigidTransform::Identity();
    X_GP.translation() = part.box_G.center();
    const bool finger = part.side != 0;
    bodies.push_back({part.side > 0   ? "left_finger"
                      : part.side < 0 ? "right_finger"
                                      : "housing",
                      finger ? world.finger_mesh : world.housing_mesh, gripper.X_WG * X_GP, metal,
                      part.box_G.sizes().z()});
    if (!finger) continue;
    const double pad_y = 0.5 * (gripper.opening + world.scene.gripper.pad.thickness);
    X_GP.translation() = Eigen::Vector3d(0, part.side * pad_y, 0);
    bodies.push_back({part.side > 0 ? "left_pad" : "right_pad", world.pad_mesh, gripper.X_WG * X_GP,
                      foam, world.scene.gripper.pad.length()});
  }
  return bodies;
}

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
