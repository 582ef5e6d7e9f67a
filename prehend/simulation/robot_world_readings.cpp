// What a RobotWorld tells of itself.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "prehend/simulation/robot_world_implementation.h"

namespace prehend::simulation {

using engines::TouchPoint;
using geometry::RigidTransform;

namespace {

std::shared_ptr<const geometry::TriangleMesh> mesh_of(const robot::CollisionShape& shape) {
  using Kind = robot::CollisionShape::Kind;
  const auto owned = [](geometry::TriangleMesh mesh) {
    return std::make_shared<const geometry::TriangleMesh>(std::move(mesh));
  };
  switch (shape.kind) {
    case Kind::kBox:
      return owned(geometry::make_box(shape.size));
    case Kind::kSphere:
      return owned(geometry::make_sphere(shape.radius, 32));
    case Kind::kCylinder:
      return owned(geometry::make_revolution(
          {{shape.radius, -0.5 * shape.length}, {shape.radius, 0.5 * shape.length}}, 48));
    case Kind::kMesh:
      break;
  }
  return shape.solid;
}

}  // namespace

bool RobotWorld::Implementation::is_hands(int body) const {
  if (body < 0 || body >= static_cast<int>(robot.bodies.size())) return false;
  const std::size_t b = static_cast<std::size_t>(body);
  return !robot.bodies[b].is_fixed ||
         body == robot.body_of_link[static_cast<std::size_t>(robot.hand_root)];
}

ContactWrench RobotWorld::Implementation::contact_wrench() const {
  const RigidTransform X_WHand = X_WL(robot.hand_root);
  ContactWrench wrench;
  for (const TouchPoint& touch_point : state.touches) {
    const bool a = is_hands(touch_point.a), b = is_hands(touch_point.b);
    if (a == b) continue;
    const Eigen::Vector3d force = (a ? 1.0 : -1.0) * touch_point.force;
    wrench.force += force;
    wrench.torque += (touch_point.at.p_W - X_WHand.translation()).cross(force);
  }
  for (const engines::PadLoad& load : state.pad_loads) {
    wrench.force -= load.wrench_W.head<3>();
    wrench.torque -=
        load.wrench_W.tail<3>() + (load.p_W - X_WHand.translation()).cross(load.wrench_W.head<3>());
  }
  wrench.force = X_WHand.linear().transpose() * wrench.force;
  wrench.torque = X_WHand.linear().transpose() * wrench.torque;
  return wrench;
}

RobotWorld::Implementation::Thing& RobotWorld::Implementation::thing(const std::string& name) {
  for (Thing& thing : things) {
    if (thing.model.name == name) return thing;
  }
  throw std::invalid_argument("there is no object '" + name + "'");
}

RobotBodyReading RobotWorld::Implementation::reading(const Thing& thing) const {
  RobotBodyReading reading;
  const engines::BodyMotion motion = system->motion(state, thing.body);
  reading.name = thing.model.name;
  reading.X_WB = motion.X_WB * thing.X_CB;
  reading.velocity = motion.velocity;
  reading.angular_velocity = motion.angular_velocity;
  reading.mass = thing.model.mass;
  reading.asleep = thing.asleep;
  reading.height = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : thing.model.hull_points) {
    reading.height = std::min(reading.height, (reading.X_WB * p).z());
  }
  reading.touches_table = thing.asleep;
  for (const TouchPoint& touch_point : state.touches) {
    if (!(touch_point.normal_force > 0)) continue;
    if (touch_point.a != thing.body && touch_point.b != thing.body) continue;
    const int other = touch_point.a == thing.body ? touch_point.b : touch_point.a;
    if (other < 0) reading.touches_table = true;
    if (other >= 0 && other < static_cast<int>(robot.bodies.size())) reading.touches_robot = true;
  }
  reading.touches_robot = reading.touches_robot || pad_normal_force(thing.body) > 0;
  return reading;
}

std::vector<JointReading> RobotWorld::joints() const {
  const Implementation& world = *implementation_;
  std::vector<JointReading> readings;
  if (world.arm) {
    for (int i = 0; i < world.arm->chain().size(); ++i) {
      readings.push_back({world.arm->chain().joints()[static_cast<std::size_t>(i)].name,
                          world.arm->position()[i], world.arm->velocity()[i], 0});
    }
  }
  for (std::size_t j = 0; j < world.robot.model.joints.size(); ++j) {
    const int engine = world.robot.engine_joint[j];
    if (engine < 0) continue;
    const engines::EngineJoint& joint = world.robot.joints[static_cast<std::size_t>(engine)];
    const double ratio = joint.follows >= 0 ? joint.ratio : 1.0;
    const int c = world.robot.coordinate[static_cast<std::size_t>(engine)];
    JointReading reading{world.robot.model.joints[j].name, ratio * world.state.positions[c],
                         ratio * world.state.velocities[c], 0};
    for (std::size_t m = 0; m < world.robot.motors.size(); ++m) {
      if (world.robot.motors[m].model_joint == static_cast<int>(j)) {
        reading.effort = world.hand->effort(*world.system, static_cast<int>(m));
      }
    }
    readings.push_back(reading);
  }
  return readings;
}

std::vector<LinkContact> RobotWorld::link_contacts() const {
  const Implementation& world = *implementation_;
  std::map<int, LinkContact> found;
  const auto add = [&](int body, const TouchPoint& touch_point, double sign) {
    if (body < 0 || body >= static_cast<int>(world.robot.bodies.size())) return;
    LinkContact& contact = found[body];
    contact.link = world.robot.bodies[static_cast<std::size_t>(body)].name;
    ++contact.points;
    contact.force += sign * touch_point.force;
    contact.normal_force += touch_point.normal_force;
  };
  for (const TouchPoint& touch_point : world.state.touches) {
    if (!(touch_point.normal_force > 0)) continue;
    add(touch_point.a, touch_point, 1);
    add(touch_point.b, touch_point, -1);
  }
  for (std::size_t k = 0; k < world.state.pad_loads.size(); ++k) {
    const engines::PadLoad& load = world.state.pad_loads[k];
    if (!(load.normal_force > 0)) continue;
    const engines::PadOnBody& touch = world.system->pad_touches()[k];
    LinkContact& contact = found[touch.carrier];
    contact.link = world.robot.bodies[static_cast<std::size_t>(touch.carrier)].name;
    const std::vector<double>& texels = world.state.pads[k].normal_force;
    contact.points += static_cast<int>(
        std::count_if(texels.begin(), texels.end(), [](double force) { return force > 0; }));
    contact.force -= load.wrench_W.head<3>();
    contact.normal_force += load.normal_force;
  }
  std::vector<LinkContact> contacts;
  for (auto& [body, contact] : found) contacts.push_back(std::move(contact));
  return contacts;
}

double RobotWorld::Implementation::pad_normal_force(int body) const {
  double sum = 0;
  for (std::size_t k = 0; k < state.pad_loads.size(); ++k) {
    if (system->pad_touches()[k].body == body) sum += state.pad_loads[k].normal_force;
  }
  return sum;
}

std::vector<double> RobotWorld::Implementation::pad_forces(std::size_t pad) const {
  std::vector<double> forces(hand_model.pads[pad].layout->size());
  engines::add_pad_forces(system->pad_touches(), state.pads, static_cast<int>(pad), forces);
  return forces;
}

void RobotWorld::Implementation::read_sensors() {
  wrist = sensors.shown(contact_wrench());
  if (!sensors.frames_due(options.step)) return;
  for (std::size_t pad = 0; pad < hand_model.pads.size(); ++pad) {
    sensors.take_frame(pad, pad_forces(pad));
  }
}

std::vector<HandPadReading> RobotWorld::pads() const {
  const Implementation& world = *implementation_;
  std::vector<HandPadReading> readings;
  for (std::size_t i = 0; i < world.hand_model.pads.size(); ++i) {
    const robot::HandPad& pad = world.hand_model.pads[i];
    HandPadReading reading;
    reading.name = pad.name;
    reading.rows = pad.model.rows;
    reading.columns = pad.model.columns;
    reading.force = world.pad_forces(i);
    for (const double force : reading.force) reading.sum += force;
    reading.counts = world.sensors.ideal_pads() ? world.sensors.ideal_counts(i, reading.force)
                                                : world.sensors.frame(i);
    readings.push_back(std::move(reading));
  }
  return readings;
}

ContactWrench RobotWorld::wrist_wrench() const { return implementation_->wrist; }
RigidTransform RobotWorld::X_WH() const {
  return implementation_->X_WL(implementation_->robot.hand_root);
}
std::size_t RobotWorld::body_count() const { return implementation_->things.size(); }
RobotBodyReading RobotWorld::body(std::size_t index) const {
  return implementation_->reading(implementation_->things.at(index));
}
RobotBodyReading RobotWorld::body(const std::string& name) const {
  return implementation_->reading(implementation_->thing(name));
}

std::vector<RobotWorld::ObjectTouch> RobotWorld::object_touches(const std::string& name) const {
  const Implementation& world = *implementation_;
  const int body = implementation_->thing(name).body;
  std::vector<ObjectTouch> touches;
  for (const TouchPoint& touch_point : world.state.touches) {
    if (touch_point.a != body || !(touch_point.normal_force > 0)) continue;
    if (touch_point.b < 0 || touch_point.b >= static_cast<int>(world.robot.bodies.size())) continue;
    const std::size_t link_body = static_cast<std::size_t>(touch_point.b);
    touches.push_back({touch_point.at.p_W, touch_point.force, world.robot.bodies[link_body].name,
                       world.robot.finger_of_body[link_body]});
  }
  for (std::size_t k = 0; k < world.state.pad_loads.size(); ++k) {
    const engines::PadOnBody& pad = world.system->pad_touches()[k];
    if (pad.body != body || !(world.state.pad_loads[k].normal_force > 0)) continue;
    const std::size_t link_body = static_cast<std::size_t>(pad.carrier);
    const RigidTransform X_WP = world.state.X_WB[link_body] * pad.X_CP;
    const contact::PadState& texels = world.state.pads[k];
    for (std::size_t i = 0; i < pad.layout.size(); ++i) {
      if (!(texels.normal_force[i] > 0)) continue;
      const Eigen::Vector3d n = pad.layout.normal(i);
      const Eigen::Vector3d force = texels.normal_force[i] * n -
                                    texels.friction_u[i] * pad.layout.first_tangent(i) -
                                    texels.friction_v[i] * pad.layout.second_tangent(i);
      touches.push_back({X_WP * (pad.layout.position(i) - texels.depth[i] * n),
                         X_WP.linear() * force, world.robot.bodies[link_body].name,
                         world.robot.finger_of_body[link_body]});
    }
  }
  return touches;
}

void RobotWorld::show_robot(bool show) { implementation_->shows_robot = show; }

std::vector<VisibleBody> RobotWorld::visible_bodies() const {
  const Implementation& world = *implementation_;
  std::vector<VisibleBody> bodies;
  for (const Implementation::Thing& thing : world.things) {
    bodies.push_back({thing.model.name, thing.model.mesh, world.reading(thing).X_WB,
                      thing.model.texture, thing.model.box.sizes().z()});
  }
  if (!world.shows_robot) return bodies;
  Texture metal;
  metal.color = {0.55, 0.55, 0.58};
  for (std::size_t l = 0; l < world.robot.model.links.size(); ++l) {
    const robot::Link& link = world.robot.model.links[l];
    for (const robot::CollisionShape& shape : link.shapes) {
      const auto mesh = mesh_of(shape);
      bodies.push_back({link.name, mesh, world.X_WL(static_cast<int>(l)) * shape.X_LS, metal,
                        geometry::bounds(*mesh).sizes().z()});
    }
  }
  return bodies;
}

}  // namespace prehend::simulation
