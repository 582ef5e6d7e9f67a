#include "prehend/simulation/contact_detection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "prehend/simulation/mesh_surface.h"

namespace prehend::simulation {
namespace {

// Deeper than this two bodies are not pushed apart: the nearest face is then a guess [m].
constexpr double kDeepest = 0.01;

ContactPoint make_contact(const BodyModel& model, int index, std::uint32_t partner,
                          std::size_t point_index) {
  ContactPoint contact;
  contact.key = contact_key(model.id, partner, static_cast<std::uint32_t>(point_index));
  contact.partner = partner;
  contact.a = index;
  return contact;
}

// Shortest way out of a box for a point inside: depth [m] and outward normal. The face towards the
// housing is none, since the finger goes on there.
double depth_in_box(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p, bool is_finger,
                    Eigen::Vector3d& normal) {
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double to_min = p[axis] - box.min()[axis], to_max = box.max()[axis] - p[axis];
    if (to_min < 0 || to_max < 0) return -1;
    if (to_min < least && !(is_finger && axis == 2)) {
      least = to_min;
      normal = -Eigen::Vector3d::Unit(axis);
    }
    if (to_max < least) {
      least = to_max;
      normal = Eigen::Vector3d::Unit(axis);
    }
  }
  return least;
}

void detect_box(const BodyModel& model, const geometry::RigidTransform& X_GB, int index,
                const GripperBox& part, const GripperPlacement& placement,
                std::vector<ContactPoint>& contacts) {
  const bool is_pad = part.partner == kLeftPad || part.partner == kRightPad;
  // Cull in B first: only points within the part's bounds there are turned into G.
  const Eigen::AlignedBox3d part_B = transformed_box(X_GB.inverse(), part.box_G);
  for (std::size_t i = 0; i < model.surface_points.size(); ++i) {
    if (!part_B.contains(model.surface_points[i])) continue;
    const Eigen::Vector3d p_G = X_GB * model.surface_points[i];
    Eigen::Vector3d normal_G = Eigen::Vector3d::Zero();
    double depth = 0;
    if (!is_pad) {
      depth = depth_in_box(part.box_G, p_G, part.side != 0, normal_G);
    } else if (part.box_G.contains(p_G)) {
      // As texels do, a pad pushes along its normal only.
      normal_G = Eigen::Vector3d(0, -part.side, 0);
      depth = part.side > 0 ? p_G.y() - part.box_G.min().y() : part.box_G.max().y() - p_G.y();
    }
    if (depth <= 0) continue;
    ContactPoint contact = make_contact(model, index, part.partner, i);
    contact.law = is_pad ? &model.rigid_pad_law : &model.rigid_law;
    contact.point = placement.X_WG * p_G;
    contact.normal = placement.X_WG.linear() * normal_G;
    contact.depth = depth;
    contact.partner_velocity = placement.velocity_at(contact.point);
    // The slide closes: both jaws by half of it.
    contact.slide_motion = -0.5 * part.side * placement.X_WG.linear().col(1);
    contacts.push_back(contact);
  }
}

// How deep a point is inside a body [m] and the outward normal of the nearest face; negative when
// it is not, or deeper than kDeepest.
double depth_in_body(const BodyModel& model, const Eigen::Vector3d& p_B, Eigen::Vector3d& normal) {
  const contact::Shape& shape = model.felt.shape;
  if (shape.kind() != contact::Shape::Kind::kMesh) {
    const double depth = shape.depth_inside(model.felt.X_BS.inverse(Eigen::Isometry) * p_B, normal);
    normal = model.felt.X_BS.linear() * normal;
    return depth;
  }
  double depth = 0;
  return mesh_depth(*model.query, p_B, kDeepest, normal, depth) ? depth : -1;
}

// Points of `model_a` inside body b.
void detect_points_in_body(const BodyModel& model_a, const geometry::RigidTransform& X_WA, int a,
                           const BodyModel& model_b, const geometry::RigidTransform& X_WB, int b,
                           std::vector<ContactPoint>& contacts) {
  const geometry::RigidTransform X_BA = X_WB.inverse() * X_WA;
  const Eigen::AlignedBox3d b_in_A = transformed_box(X_BA.inverse(), model_b.box);
  for (std::size_t i = 0; i < model_a.surface_points.size(); ++i) {
    if (!b_in_A.contains(model_a.surface_points[i])) continue;
    const Eigen::Vector3d p_B = X_BA * model_a.surface_points[i];
    if (!model_b.box.contains(p_B)) continue;
    Eigen::Vector3d normal_B;
    const double depth = depth_in_body(model_b, p_B, normal_B);
    if (!(depth > 0 && depth < kDeepest)) continue;
    ContactPoint contact = make_contact(model_a, a, kOtherBody + model_b.id, i);
    contact.b = b;
    contact.law = &model_a.rigid_law;
    contact.point = X_WB * p_B;
    contact.normal = X_WB.linear() * normal_B;
    contact.depth = depth;
    contacts.push_back(contact);
  }
}

}  // namespace

Eigen::AlignedBox3d transformed_box(const geometry::RigidTransform& X_FB,
                                    const Eigen::AlignedBox3d& box_B) {
  const Eigen::Vector3d center = X_FB * box_B.center();
  const Eigen::Vector3d half = X_FB.linear().cwiseAbs() * (0.5 * box_B.sizes());
  return {center - half, center + half};
}

std::array<GripperBox, 3> gripper_boxes(const robot::GripperModel& model, double opening) {
  const double half_x = 0.5 * model.finger_size.x();
  const double near_y = 0.5 * opening + model.pad.thickness;
  const double far_y = 0.5 * opening + model.finger_size.y();
  const double front = model.housing_front_z();
  const double tip = model.tip_z();
  using Point = Eigen::Vector3d;
  const Eigen::AlignedBox3d left(Point(-half_x, near_y, front), Point(half_x, far_y, tip));
  const Eigen::AlignedBox3d right(Point(-half_x, -far_y, front), Point(half_x, -near_y, tip));
  const Point& size = model.housing_size;
  const Eigen::AlignedBox3d housing(Point(-0.5 * size.x(), -0.5 * size.y(), front - size.z()),
                                    Point(0.5 * size.x(), 0.5 * size.y(), front));
  return {{{left, 1, kLeftFinger}, {right, -1, kRightFinger}, {housing, 0, kHousing}}};
}

std::array<GripperBox, 2> pad_boxes(const robot::GripperModel& model, double opening) {
  const Eigen::Vector3d half(0.5 * model.pad.width(), 0, 0.5 * model.pad.length());
  std::array<GripperBox, 2> boxes;
  for (int k = 0; k < 2; ++k) {
    const double side = k == 0 ? 1 : -1;
    const Eigen::Vector3d face(0, 0.5 * side * opening, 0);
    boxes[k] = {Eigen::AlignedBox3d(face - half, face + half), side, k == 0 ? kLeftPad : kRightPad};
    boxes[k].box_G.extend(face + Eigen::Vector3d(0, side * model.pad.thickness, 0));
  }
  return boxes;
}

void detect_table(const BodyModel& model, const BodyState& state, int index, double h,
                  std::vector<ContactPoint>& contacts) {
  const double radius = model.box.sizes().norm();
  const double reach = h * (state.velocity.norm() + radius * state.angular_velocity.norm());
  if (state.p_WBcm.z() > radius + reach) return;
  const Eigen::Matrix3d R_WB = state.q_WB.toRotationMatrix();
  const Eigen::RowVector3d up = R_WB.row(2);
  const double base = state.p_WBcm.z() - up * model.center_of_mass;
  for (std::size_t i = 0; i < model.hull_points.size(); ++i) {
    const double z = base + up * model.hull_points[i];
    if (z > reach || z == 0) continue;
    ContactPoint contact = make_contact(model, index, kTable, i);
    contact.law = &model.table_law;
    contact.point = state.p_WBcm + R_WB * (model.hull_points[i] - model.center_of_mass);
    contact.depth = -z;
    contacts.push_back(contact);
  }
}

bool near_gripper(const BodyModel& model, const BodyState& state,
                  const robot::GripperModel& gripper, const GripperPlacement& placement,
                  double margin) {
  const geometry::RigidTransform X_GB =
      placement.X_WG.inverse(Eigen::Isometry) * body_pose(model, state);
  Eigen::AlignedBox3d body_G = transformed_box(X_GB, model.box);
  body_G.min().array() -= margin;
  body_G.max().array() += margin;
  Eigen::AlignedBox3d all;
  for (const auto& part : gripper_boxes(gripper, placement.opening)) all.extend(part.box_G);
  for (const auto& pad : pad_boxes(gripper, placement.opening)) all.extend(pad.box_G);
  return all.intersects(body_G);
}

void detect_gripper(const BodyModel& model, const BodyState& state, int index,
                    const robot::GripperModel& gripper, const GripperPlacement& placement,
                    bool rigid_pads, std::vector<ContactPoint>& contacts) {
  const geometry::RigidTransform X_GB =
      placement.X_WG.inverse(Eigen::Isometry) * body_pose(model, state);
  const Eigen::AlignedBox3d body_G = transformed_box(X_GB, model.box);
  const auto detect = [&](const GripperBox& part) {
    if (part.box_G.intersects(body_G)) detect_box(model, X_GB, index, part, placement, contacts);
  };
  for (const auto& part : gripper_boxes(gripper, placement.opening)) detect(part);
  if (!rigid_pads) return;
  for (const auto& pad : pad_boxes(gripper, placement.opening)) detect(pad);
}

void detect_bodies(const BodyModel& model_a, const BodyState& state_a, int a,
                   const BodyModel& model_b, const BodyState& state_b, int b, bool check_bounds,
                   std::vector<ContactPoint>& contacts) {
  const geometry::RigidTransform X_WA = body_pose(model_a, state_a);
  const geometry::RigidTransform X_WB = body_pose(model_b, state_b);
  if (check_bounds &&
      !transformed_box(X_WA, model_a.box).intersects(transformed_box(X_WB, model_b.box))) {
    return;
  }
  detect_points_in_body(model_a, X_WA, a, model_b, X_WB, b, contacts);
  detect_points_in_body(model_b, X_WB, b, model_a, X_WA, a, contacts);
}

}  // namespace prehend::simulation
