#include "prehend/robot/formats/collada_extra_writer.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_shape_writer.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using Kind = JointDescription::Kind;

bool moves(const JointDescription& joint) {
  return joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic ||
         joint.kind == Kind::kBall;
}

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
bool has_space(const std::string& name) { return std::any_of(name.begin(), name.end(), is_space); }

/// "kmodel0/link3"; empty: there is no such link.
std::string link_path(const RobotDescription& robot, const std::string& name) {
  const LinkDescription* link = robot.link(name);
  return link ? fmt::format("kmodel0/link{}", link - robot.links.data()) : std::string();
}
std::string joint_path(const RobotDescription& robot, const std::string& name) {
  const JointDescription* joint = robot.joint(name);
  return joint ? fmt::format("kmodel0/joint{}", joint - robot.joints.data()) : std::string();
}

void open_extra(const char* type, const std::string& name, ColladaText& text) {
  text.open("extra",
            xml_attribute("type", type) + (name.empty() ? "" : xml_attribute("name", name)));
  text.open("technique", " profile=\"OpenRAVE\"");
}
void close_extra(ColladaText& text) {
  text.close();
  text.close();
}

bool has_motor(const JointDescription& joint) {
  return moves(joint) &&
         ((joint.effort && *joint.effort > 0) || joint.damping != 0 || joint.friction != 0);
}

struct Motor {
  std::string name;  // of the actuator; none: it tells of its joint
  std::string joint;
  double gear = 1;
  std::optional<double> effort;
  std::string control;
  double damping = 0, friction = 0;
};

std::vector<Motor> motors(const RobotDescription& robot) {
  std::vector<Motor> all;
  for (const Actuator& one : robot.actuators) {
    if (robot.joint(one.joint) && !one.name.empty()) {
      all.push_back({one.name, one.joint, one.gear, one.effort, one.control, 0, 0});
    }
  }
  for (const JointDescription& one : robot.joints) {
    if (has_motor(one)) all.push_back({"", one.name, 1, one.effort, "", one.damping, one.friction});
  }
  return all;
}

std::string sensor_type(const std::string& kind) {
  for (const auto& [own, openrave] : kColladaSensorTypes) {
    if (kind == own) return std::string(openrave);
  }
  return kind;
}

void write_motor(const Motor& motor, std::size_t number, ColladaText& text) {
  text.open("actuator", fmt::format(" id=\"actuator{}\"", number) +
                            (motor.name.empty() ? "" : xml_attribute("name", motor.name)) +
                            " type=\"electric_motor\"");
  text.leaf("gear_ratio", "", number_text(motor.gear));
  if (motor.effort && *motor.effort > 0) {
    // At the motor's own shaft.
    const double gear = motor.gear == 0 ? 1 : motor.gear;
    text.leaf("max_instantaneous_torque", "", number_text(*motor.effort / gear));
  }
  if (motor.friction != 0) text.leaf("coloumb_friction", "", number_text(motor.friction));
  if (motor.damping != 0) text.leaf("viscous_friction", "", number_text(motor.damping));
  text.close();
}

}  // namespace

std::vector<std::string> collada_names(const std::vector<std::string>& names) {
  std::set<std::string> used;
  for (const std::string& name : names) {
    if (!has_space(name)) used.insert(name);
  }
  std::vector<std::string> written = names;
  for (std::string& name : written) {
    if (!has_space(name)) continue;
    std::replace_if(name.begin(), name.end(), is_space, '_');
    while (!used.insert(name).second) name += '_';
  }
  return written;
}

void write_model_extras(const RobotDescription& robot, ColladaText& text) {
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (!has_space(robot.links[i].name)) continue;
    open_extra("link_info", fmt::format("link{}", i), text);
    text.leaf("string_value", " name=\"name\"", robot.links[i].name);
    close_extra(text);
  }
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const JointDescription& joint = robot.joints[i];
    if (!joint.stiffness && !joint.break_away && !has_space(joint.name)) continue;
    open_extra("joint_info", fmt::format("joint{}", i), text);
    if (has_space(joint.name)) text.leaf("string_value", " name=\"name\"", joint.name);
    if (joint.stiffness) {
      text.leaf("float_array", " name=\"spring\"",
                number_text(*joint.stiffness) + " " + number_text(joint.rest));
    }
    if (joint.break_away) {
      text.leaf("float_array", " name=\"break_away\"", number_text(*joint.break_away));
    }
    close_extra(text);
  }
  const auto is_untouched = [](const LinkDescription& link) {
    return std::none_of(link.collisions.begin(), link.collisions.end(),
                        [](const Shape& one) { return is_in_collada(one, false); }) &&
           std::any_of(link.visuals.begin(), link.visuals.end(),
                       [](const Shape& one) { return is_in_collada(one, true); });
  };
  if (robot.disabled_collisions.empty() &&
      std::none_of(robot.links.begin(), robot.links.end(), is_untouched)) {
    return;
  }
  open_extra("collision", "", text);
  for (const auto& [first, second] : robot.disabled_collisions) {
    if (!robot.link(first) || !robot.link(second)) continue;
    text.leaf("ignore_link_pair", xml_attribute("link0", link_path(robot, first)) +
                                      xml_attribute("link1", link_path(robot, second)));
  }
  for (const LinkDescription& link : robot.links) {
    if (!is_untouched(link)) continue;
    text.open("link_collision_state", xml_attribute("link", link_path(robot, link.name)));
    text.leaf("bool", "", "false");
    text.close();
  }
  close_extra(text);
}

void write_system_extras(const RobotDescription& robot, ColladaText& text) {
  open_extra("interface_type", "", text);
  text.leaf("interface", " type=\"robot\"", "GenericRobot");
  close_extra(text);
  for (const Manipulator& one : robot.manipulators) {
    if (!robot.link(one.base) || !robot.link(one.tip)) continue;
    open_extra("manipulator", one.name, text);
    text.leaf("frame_origin", xml_attribute("link", link_path(robot, one.base)));
    text.open("frame_tip", xml_attribute("link", link_path(robot, one.tip)));
    text.steps(one.X_TipTool);
    text.close();
    for (const auto& [joint, direction] : one.closing) {
      if (!robot.joint(joint)) continue;
      text.open("gripper_joint", xml_attribute("joint", joint_path(robot, joint)));
      text.open("chucking_direction", " axis=\"./axis0\"");
      text.leaf("float", "", number_text(direction));
      text.close();
      text.close();
    }
    close_extra(text);
  }
  const std::vector<Motor> all = motors(robot);
  for (std::size_t i = 0; i < all.size(); ++i) {
    // By the joint's name, by which OpenHRP's readers find it.
    open_extra("attach_actuator", all[i].name.empty() ? all[i].joint : all[i].name, text);
    text.leaf("instance_actuator", fmt::format(" url=\"#actuator{}\"", i));
    text.leaf("bind_actuator", xml_attribute("joint", joint_path(robot, all[i].joint)));
    text.close();
    if (!all[i].control.empty()) {
      text.open("technique", " profile=\"prehend\"");
      text.leaf("control", "", all[i].control);
      text.close();
    }
    text.close();
  }
  for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
    const Sensor& one = robot.sensors[i];
    if (!robot.link(one.link)) continue;
    open_extra("attach_sensor", one.name, text);
    text.leaf("instance_sensor", fmt::format(" url=\"#sensor{}\"", i));
    text.open("frame_origin", xml_attribute("link", link_path(robot, one.link)));
    text.steps(one.X_LS);
    text.close();
    text.close();
    if (!one.size.isZero(0)) {
      text.open("technique", " profile=\"prehend\"");
      text.leaf("size", "", numbers_text(one.size));
      text.close();
    }
    text.close();
  }
}

std::string collada_extra_libraries(const RobotDescription& robot) {
  ColladaText text(1);
  if (!robot.sensors.empty()) {
    open_extra("library_sensors", "", text);
    for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
      if (!robot.link(robot.sensors[i].link)) continue;
      text.leaf("sensor", fmt::format(" id=\"sensor{}\"", i) +
                              xml_attribute("type", sensor_type(robot.sensors[i].kind)));
    }
    close_extra(text);
  }
  const std::vector<Motor> all = motors(robot);
  if (!all.empty()) {
    open_extra("library_actuators", "", text);
    for (std::size_t i = 0; i < all.size(); ++i) write_motor(all[i], i, text);
    close_extra(text);
  }
  return text.take();
}

}  // namespace prehend::robot::formats
