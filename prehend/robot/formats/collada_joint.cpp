#include "prehend/robot/formats/collada_joint.h"

#include "prehend/robot/formats/collada_elements.h"

namespace prehend::robot::formats {

bool ColladaJoint::is_ball() const {
  if (axes.size() != 3) return false;
  Eigen::Matrix3d directions;
  for (int i = 0; i < 3; ++i) {
    const Axis& axis = axes[static_cast<std::size_t>(i)];
    if (!axis.turns || axis.lower || axis.upper) return false;
    directions.col(i) = axis.direction;
  }
  return (directions.transpose() * directions).isIdentity(1e-9);
}

std::optional<double> collada_limit(const std::optional<XmlElement>& element, bool turns,
                                    double length) {
  if (turns) return angle_in(element);
  const auto number = number_in(element);
  return number ? std::optional(length * *number) : std::nullopt;
}

ColladaJoint read_collada_joint(const XmlElement& element, double length) {
  ColladaJoint joint;
  joint.name = element.attribute("name").value_or(element.attribute("sid").value_or("joint"));
  for (const XmlElement& one : element.children()) {
    const std::string kind = one.name();
    if (kind != "revolute" && kind != "prismatic") continue;
    ColladaJoint::Axis axis;
    axis.sid = one.attribute("sid").value_or("axis0");
    axis.turns = kind == "revolute";
    if (const auto direction = one.child("axis")) {
      const auto n = direction->text_numbers(3);
      const Eigen::Vector3d given(n[0], n[1], n[2]);
      if (given.norm() > 1e-9) axis.direction = given.normalized();
    }
    if (const auto limits = one.child("limits")) {
      axis.lower = collada_limit(limits->child("min"), axis.turns, length);
      axis.upper = collada_limit(limits->child("max"), axis.turns, length);
    }
    joint.axes.push_back(axis);
  }
  return joint;
}

}  // namespace prehend::robot::formats
