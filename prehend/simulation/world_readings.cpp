// What sensors and cameras show of the world.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;

constexpr double kTipStiffness = 2e4;  // N/m, of a finger's corner against the table

}  // namespace

void World::Implementation::read_sensors(double h) {
  const GripperPlacement& gripper = stage_start;
  for (BodyState& body : state.motion.bodies) {
    body.touches_left_pad = body.touches_right_pad = body.touches_gripper = false;
    if (!body.asleep) body.touches_table = false;
  }
  // An engine's own contacts are not known here; what stands this near to the table touches it.
  constexpr double kStands = 5e-4;  // m
  for (std::size_t i = 0; engine && i < models.size(); ++i) {
    BodyState& body = state.motion.bodies[i];
    body.touches_table = lowest_point(models[i], body) < kStands;
  }
  ContactWrench wrench_W;
  const auto add_to_wrench = [&](const Eigen::Vector3d& force, const Eigen::Vector3d& point) {
    wrench_W.force += force;
    wrench_W.torque += (point - gripper.X_WG.translation()).cross(force);
  };
  const auto touch_pad = [&](BodyState& body, bool left) {
    (left ? body.touches_left_pad : body.touches_right_pad) = true;
  };
  for (const ContactPoint& contact : contacts) {
    if (contact.normal_force <= 0) continue;
    BodyState& body = state.motion.bodies[contact.a];
    if (contact.partner == kTable) body.touches_table = true;
    if (!is_gripper(contact.partner)) continue;
    add_to_wrench(-contact.force, contact.point);
    if (is_pad(contact.partner)) {
      touch_pad(body, contact.partner == kLeftPad);
    } else {
      body.touches_gripper = true;
    }
  }
  for (const PadContact& pad : pads) {
    if (pad.response->pressing == 0) continue;
    add_to_wrench(-pad.wrench_W.head<3>(), pad.place->p_WP);
    wrench_W.torque -= pad.wrench_W.tail<3>();
    touch_pad(state.motion.bodies[pad.body], pad.place == &places[0]);
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
  if (state.wrist) {
    Eigen::Matrix<double, 6, 1> wrench;
    wrench << state.wrench.force, state.wrench.torque;
    wrench = state.wrist->sample(wrench);
    state.wrench = {wrench.head<3>(), wrench.tail<3>()};
  }
  // Electronics with a memory see the pads at their own pace.
  state.frame_age += h;
  if (scene.tactile.is_ideal() || state.frame_age < scene.tactile.period * (1 - 1e-9)) return;
  for (int k : {0, 1}) {
    state.frames[k] = image(k, state.pads[k].sample(texel_forces(k), state.frame_age));
  }
  state.frame_age = 0;
}

const std::vector<double>& World::Implementation::texel_forces(int pad) {
  const contact::PadLayout& layout = mounts[pad].layout;
  forces.assign(layout.size(), 0.0);
  for (const auto& touches : state.motion.touches) {
    const PadTouch& touch = touches[pad];
    for (std::size_t i = 0; touch.presses && i < layout.size(); ++i) {
      forces[i] += touch.texels.normal_force[i];
    }
  }
  return forces;
}

// The right pad's x axis runs against the gripper's.
TactileImage World::Implementation::image(int pad, const TactileFrameReading& frame) const {
  TactileImage image{frame.rows, frame.columns, frame.counts, frame.felt};
  for (int row = 0; pad == 1 && row < frame.rows; ++row) {
    const auto texels = image.counts.begin() + static_cast<std::ptrdiff_t>(row) * frame.columns;
    std::reverse(texels, texels + frame.columns);
  }
  return image;
}

BodyReading World::Implementation::reading(std::size_t i) const {
  const BodyState& body = state.motion.bodies[i];
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
  reading.asleep = body.asleep;
  return reading;
}

bool World::has_touch() const { return !implementation_->scene.physics.rules.rigid_pads; }

TactileImage World::tactile_image(PadSide side) const {
  if (!has_touch()) {
    throw std::logic_error("this world's pads have no texels: physics.pads is rigid");
  }
  Implementation& world = *implementation_;
  const int pad = side == PadSide::kLeft ? 0 : 1;
  if (!world.scene.tactile.is_ideal()) return world.state.frames[pad];
  PadElectronics sensor = world.state.pads[pad];  // has no memory that counts
  return world.image(pad, sensor.sample(world.texel_forces(pad), 0));
}

double World::energy() const {
  double sum = 0;
  std::vector<ContactPoint> touching;
  for (std::size_t i = 0; i < body_count(); ++i) {
    const BodyModel& model = implementation_->models[i];
    const BodyState& body = implementation_->state.motion.bodies[i];
    if (model.is_static) continue;
    const Eigen::Vector3d w_B = body.q_WB.conjugate() * body.angular_velocity;
    sum += 0.5 * model.mass * body.velocity.squaredNorm() + 0.5 * w_B.dot(model.inertia * w_B) +
           model.mass * implementation_->scene.gravity * body.p_WBcm.z();
    if (!implementation_->engine) detect_table(model, body, static_cast<int>(i), 0, touching);
  }
  for (const ContactPoint& contact : touching) {
    sum += 0.5 * contact.law->stiffness * contact.depth * contact.depth;
  }
  return sum;
}

void World::show_robot(bool show) { implementation_->shows_robot = show; }

std::vector<VisibleBody> World::visible_bodies() const {
  const Implementation& world = *implementation_;
  std::vector<VisibleBody> bodies;
  for (std::size_t i = 0; i < world.models.size(); ++i) {
    const BodyModel& model = world.models[i];
    bodies.push_back({model.name, model.mesh, body_pose(model, world.state.motion.bodies[i]),
                      model.texture, model.box.max().z()});
  }
  if (!world.shows_robot) return bodies;
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

}  // namespace prehend::simulation
