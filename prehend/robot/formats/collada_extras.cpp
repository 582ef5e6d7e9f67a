#include "prehend/robot/formats/collada_extras.h"

#include <utility>

#include "prehend/robot/formats/collada_elements.h"

namespace prehend::robot::formats {
namespace {

std::optional<XmlElement> technique_of(const XmlElement& extra, const std::string& profile) {
  for (const XmlElement& one : extra.children("technique")) {
    if (one.attribute("profile").value_or("") == profile) return one;
  }
  return std::nullopt;
}

/// Of a link or joint whose name has spaces.
bool is_name(const XmlElement& parameter) {
  return parameter.name() == "string_value" && parameter.attribute("name").value_or("") == "name";
}

std::optional<double> known_number(const XmlElement& element, const char* name) {
  const auto number = number_in(element.child(name));
  // OpenHRP's writer has 0 for what it does not know.
  return number && *number != 0 ? number : std::nullopt;
}

}  // namespace

std::map<std::string, std::string> collada_names_in(const XmlElement& model) {
  std::map<std::string, std::string> names;
  for (const XmlElement& extra : model.children("extra")) {
    const std::string type = extra.attribute("type").value_or("");
    if (type != "joint_info" && type != "link_info") continue;
    const auto technique = technique_of(extra, "OpenRAVE");
    if (!technique) continue;
    for (const XmlElement& one : technique->children("string_value")) {
      if (is_name(one)) names[extra.attribute("name").value_or("")] = one.text();
    }
  }
  return names;
}

void ColladaExtras::read(const XmlElement& extra, RobotDescription& robot) {
  const std::string type = extra.attribute("type").value_or("");
  const auto technique = technique_of(extra, "OpenRAVE");
  if (!technique) return extra.drop("it is of its writer's own");
  if (type == "manipulator") {
    read_manipulator(extra, *technique, robot);
  } else if (type == "collision") {
    read_collision(*technique, robot);
  } else if (type == "joint_info") {
    read_joint_info(extra, *technique);
  } else if (type == "link_info") {
    extra.attribute("name");
    for (const XmlElement& one : technique->children()) {
      if (!is_name(one)) one.drop("its meaning is its writer's own");
    }
  } else if (type == "attach_actuator") {
    read_actuator(extra, *technique, robot);
  } else if (type == "attach_sensor") {
    read_sensor(extra, *technique, robot);
  } else if (type == "interface_type") {
    const auto kind = technique->child("interface");
    const bool is_robot =
        kind && kind->attribute("type").value_or("") == "robot" && kind->text() == "GenericRobot";
    if (!is_robot) extra.drop("it is OpenRAVE's own");
  } else {
    extra.drop("it is OpenRAVE's own");
  }
}

void ColladaExtras::read_collision(const XmlElement& technique, RobotDescription& robot) {
  for (const XmlElement& one : technique.children()) {
    const std::string what = one.name();
    if (what == "ignore_link_pair") {
      const std::string first = link_of_(one.attribute("link0"));
      const std::string second = link_of_(one.attribute("link1"));
      if (first.empty() || second.empty()) {
        one.drop("pairs of links that are not there are not kept");
      } else {
        robot.disabled_collisions.emplace_back(first, second);
      }
    } else if (what == "link_collision_state" || what == "link_visible_state") {
      const std::string link = link_of_(one.attribute("link"));
      const bool is_so = bool_in(one, true);
      if (link.empty() || (!is_so && what == "link_visible_state")) {
        one.drop("links that are hidden, or not there, are not kept so");
      } else if (!is_so) {
        untouched_.insert(link);
      }
    } else {
      one.drop("it is OpenRAVE's own");
    }
  }
}

void ColladaExtras::read_manipulator(const XmlElement& extra, const XmlElement& technique,
                                     RobotDescription& robot) {
  Manipulator manipulator;
  manipulator.name = extra.attribute("name").value_or("");
  const auto origin = technique.child("frame_origin"), tip = technique.child("frame_tip");
  manipulator.base = origin ? link_of_(origin->attribute("link")) : "";
  manipulator.tip = tip ? link_of_(tip->attribute("link")) : "";
  if (manipulator.base.empty() || manipulator.tip.empty()) {
    return extra.drop("its links are not there");
  }
  manipulator.X_TipTool = collada_steps(*tip, length_);
  if (const auto direction = tip->child("direction")) {
    direction->drop("the way it approaches is not kept");
  }
  for (const XmlElement& one : technique.children("gripper_joint")) {
    const JointDescription* joint = joint_of_(one.attribute("joint").value_or(""));
    std::optional<XmlElement> way = one.child("chucking_direction");
    if (!way) way = one.child("closing_direction");
    if (!joint) {
      one.drop("its joint is not there");
      continue;
    }
    if (way) way->attribute("axis");
    manipulator.closing.emplace_back(joint->name, number_in(way).value_or(0));
  }
  for (const char* other : {"iksolver", "interface_type", "grippername"}) {
    for (const XmlElement& one : technique.children(other)) one.drop("it is OpenRAVE's own");
  }
  robot.manipulators.push_back(std::move(manipulator));
}

void ColladaExtras::read_joint_info(const XmlElement& extra, const XmlElement& technique) {
  JointDescription* joint = joint_of_(extra.attribute("name").value_or(""));
  if (!joint) return extra.drop("its joint is not there");
  for (const XmlElement& one : technique.children()) {
    const std::string name = one.attribute("name").value_or("");
    if (one.name() == "float_array" && name == "spring") {
      const auto n = one.text_numbers(2);
      joint->stiffness = n[0];
      joint->rest = n[1];
    } else if (one.name() == "float_array" && name == "break_away") {
      joint->break_away = one.text_number();
    } else if (!is_name(one)) {
      one.drop("its meaning is its writer's own");
    }
  }
}

/// "#id" of an instance's url.
std::optional<XmlElement> ColladaExtras::instanced(const std::optional<XmlElement>& instance) {
  return instance ? document_.by_url(instance->attribute("url").value_or("")) : std::nullopt;
}

void ColladaExtras::read_actuator(const XmlElement& extra, const XmlElement& technique,
                                  RobotDescription& robot) {
  const auto bind = technique.child("bind_actuator");
  JointDescription* joint = bind ? joint_of_(bind->attribute("joint").value_or("")) : nullptr;
  const auto motor = instanced(technique.child("instance_actuator"));
  if (!joint || !motor) {
    return extra.drop(joint ? "no motor is named" : "its joint is not there");
  }
  extra.attribute("name");
  motor->attribute("type");
  // What is of the motor's own shaft is at the joint by the gear.
  const double gear = known_number(*motor, "gear_ratio").value_or(1);
  std::optional<double> torque;
  for (const char* name : {"max_instantaneous_torque", "stall_torque", "nominal_torque"}) {
    if (!torque) torque = known_number(*motor, name);
  }
  if (torque) torque = *torque * gear;
  const auto friction = known_number(*motor, "coloumb_friction"),
             damping = known_number(*motor, "viscous_friction");
  if (friction) joint->friction = *friction;
  if (damping) joint->damping = *damping;
  const std::string name = motor->attribute("name").value_or("");
  if (name.empty()) {
    if (torque) joint->effort = torque;
    return;
  }
  Actuator actuator{name, joint->name, gear, torque, ""};
  if (const auto own = technique_of(extra, "prehend")) {
    if (const auto control = own->child("control")) actuator.control = control->text();
  }
  robot.actuators.push_back(std::move(actuator));
}

void ColladaExtras::read_sensor(const XmlElement& extra, const XmlElement& technique,
                                RobotDescription& robot) {
  Sensor sensor;
  sensor.name = extra.attribute("name").value_or("");
  const auto origin = technique.child("frame_origin");
  sensor.link = origin ? link_of_(origin->attribute("link")) : "";
  const auto device = instanced(technique.child("instance_sensor"));
  if (sensor.link.empty() || !device) {
    return extra.drop(device ? "its link is not there" : "its sensor is not in the document");
  }
  sensor.X_LS = collada_steps(*origin, length_);
  device->attribute("name");
  sensor.kind = device->attribute("type").value_or("");
  for (const auto& [own, openrave] : kColladaSensorTypes) {
    if (sensor.kind == openrave) sensor.kind = own;
  }
  if (const auto own = technique_of(extra, "prehend")) {
    if (const auto size = own->child("size")) {
      const auto n = size->text_numbers(3);
      sensor.size = Eigen::Vector3d(n[0], n[1], n[2]);
    }
  }
  robot.sensors.push_back(std::move(sensor));
}

}  // namespace prehend::robot::formats
