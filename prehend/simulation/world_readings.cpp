// What sensors and cameras show of the world.

#include <algorithm>
#include <cmath>

#include "prehend/simulation/world_implementation.h"

namespace prehend::simulation {
namespace {

using geometry::RigidTransform;

constexpr double kTipStiffness = 2e4;  // N/m, of a finger's corner against the table

}  // namespace

void World::Implementation::read_sensors(const GripperPlacement& gripper) {
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
      state.pads[contact.partner == kLeftPad ? 0 : 1].force[contact.texel] += contact.normal_force;
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

BodyReading World::Implementation::reading(std::size_t i) const {
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

}  // namespace prehend::simulation
