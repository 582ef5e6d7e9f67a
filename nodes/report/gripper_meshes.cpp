#include "nodes/report/gripper_meshes.h"

namespace prehend::nodes {
namespace {

geometry::TriangleMesh box_at(const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  return geometry::transformed(geometry::make_box(size),
                               geometry::make_transform(Eigen::Quaterniond::Identity(), center));
}

}  // namespace

geometry::TriangleMesh gripper_body(const robot::GripperModel& gripper, double opening) {
  const Eigen::Vector3d& finger = gripper.finger_size;
  const double finger_y = (opening + finger.y()) / 2 + gripper.pad.thickness;
  const double finger_z = gripper.tip_z() - finger.z() / 2;
  return geometry::concatenated(
      {box_at(finger, {0, finger_y, finger_z}), box_at(finger, {0, -finger_y, finger_z}),
       box_at(gripper.housing_size,
              {0, 0, gripper.housing_front_z() - gripper.housing_size.z() / 2})});
}

geometry::TriangleMesh gripper_pads(const robot::GripperModel& gripper, double opening) {
  const auto& pad = gripper.pad;
  const Eigen::Vector3d size(pad.width(), pad.thickness, pad.length());
  const double y = (opening + pad.thickness) / 2;
  return geometry::concatenated({box_at(size, {0, y, 0}), box_at(size, {0, -y, 0})});
}

}  // namespace prehend::nodes
