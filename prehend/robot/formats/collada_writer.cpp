#include "prehend/robot/formats/collada_writer.h"

#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "prehend/robot/formats/collada_extra_writer.h"
#include "prehend/robot/formats/collada_losses.h"
#include "prehend/robot/formats/collada_shape_writer.h"
#include "prehend/robot/formats/collada_text.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using Kind = JointDescription::Kind;

class ColladaWriter {
 public:
  explicit ColladaWriter(const RobotDescription& robot) : robot_(robot), shapes_(robot) {
    // COLLADA, its library, model and technique_common, and two for each link.
    constexpr std::size_t kMostAbove = 46;
    refuse_deep_links(robot, kMostAbove, "COLLADA");
    root_ = roots(robot).front();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      number_of_joint_[robot.joints[i].name] = i;
      below_[robot.joints[i].parent].push_back(i);
    }
    for (std::size_t i = 0; i < robot.links.size(); ++i) number_of_link_[robot.links[i].name] = i;
    for (const JointDescription& joint : robot.joints) joint_names_.push_back(joint.name);
    for (const LinkDescription& link : robot.links) link_names_.push_back(link.name);
    joint_names_ = collada_names(joint_names_);
    link_names_ = collada_names(link_names_);
  }

  std::string text() {
    RobotDescription at_zero = robot_;
    for (JointDescription& joint : at_zero.joints) joint.follows.reset();
    const std::map<std::string, RigidTransform> X_RL = link_poses(at_zero, {});
    const std::string all = visual_scene() + kinematics() + systems() + physics(X_RL);
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
           "<COLLADA xmlns=\"http://www.collada.org/2008/03/COLLADASchema\" version=\"1.5.0\">\n"
           " <asset>\n"
           "  <contributor><authoring_tool>prehend</authoring_tool></contributor>\n"
           "  <created>1970-01-01T00:00:00Z</created>\n"
           "  <modified>1970-01-01T00:00:00Z</modified>\n"
           "  <unit meter=\"1\" name=\"meter\"/>\n"
           "  <up_axis>Z_UP</up_axis>\n"
           " </asset>\n" +
           shapes_.libraries() + all + scene() + collada_extra_libraries(robot_) + "</COLLADA>\n";
  }

 private:
  static std::string joint_sid(std::size_t joint) { return fmt::format("joint{}", joint); }
  static std::string axis_sid(std::size_t joint, int axis) {
    return fmt::format("joint{}_axis{}", joint, axis);
  }
  /// A ball is three axes, as OpenRAVE has it.
  static std::vector<Eigen::Vector3d> axes_of(const JointDescription& joint) {
    if (joint.kind == Kind::kBall) {
      return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
    }
    return {has_axis(joint) ? joint.axis_J : Eigen::Vector3d::UnitZ()};
  }
  static const char* axis_kind(const JointDescription& joint) {
    return joint.kind == Kind::kPrismatic ? "prismatic" : "revolute";
  }
  static std::string limit_text(const JointDescription& joint, double limit) {
    return joint.kind == Kind::kPrismatic ? number_text(limit) : degrees_text(limit);
  }
  bool is_moved(const JointDescription& joint) const {
    return (has_axis(joint) || joint.kind == Kind::kBall) && !is_held(joint);
  }
  const Follows* leader_of(const JointDescription& joint) const {
    const bool follows = joint.follows && has_axis(joint) && !is_held(joint);
    return follows && robot_.joint(joint.follows->joint) ? &*joint.follows : nullptr;
  }

  // Nodes: each within that of the link above, moved by steps that are bound to the axes.
  std::string visual_scene() {
    ColladaText text(1);
    text.open("library_visual_scenes");
    text.open("visual_scene", " id=\"vscene\"");
    text.open("node", " id=\"visual0\"");
    write_node(number_of_link_.at(root_), nullptr, text);
    for (int i = 0; i < 3; ++i) text.close();
    return text.take();
  }

  void write_node(std::size_t link, const JointDescription* joint, ColladaText& text) {
    const LinkDescription& its = robot_.links[link];
    text.open("node", fmt::format(" id=\"node{0}\" sid=\"node{0}\"", link) +
                          xml_attribute("name", link_names_[link]));
    if (joint) {
      text.steps(joint->X_PJ);
      const std::size_t number = number_of_joint_.at(joint->name);
      const auto axes = axes_of(*joint);
      for (std::size_t i = 0; i < axes.size(); ++i) {
        const bool slides = joint->kind == Kind::kPrismatic;
        text.leaf(slides ? "translate" : "rotate",
                  xml_attribute("sid", axis_sid(number, static_cast<int>(i))),
                  slides ? "0 0 0" : numbers_text(axes[i]) + " 0");
      }
      text.steps(joint->X_JC);
    }
    shapes_.write_nodes(its, text);
    for (const std::size_t below : below_[its.name]) {
      const JointDescription& next = robot_.joints[below];
      write_node(number_of_link_.at(next.child), &next, text);
    }
    text.close();
  }

  // Joints and links.
  std::string kinematics() {
    ColladaText text(1);
    text.open("library_kinematics_models");
    text.open("kinematics_model", " id=\"kmodel0\"" + xml_attribute("name", robot_.name));
    text.open("technique_common");
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) write_joint(i, text);
    write_link(number_of_link_.at(root_), nullptr, text);
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) write_formula(i, text);
    text.close();
    write_model_extras(robot_, text);
    text.close();
    text.close();
    return text.take();
  }

  void write_joint(std::size_t number, ColladaText& text) {
    const JointDescription& joint = robot_.joints[number];
    text.open("joint", xml_attribute("sid", joint_sid(number)) +
                           xml_attribute("name", joint_names_[number]));
    const auto axes = axes_of(joint);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      text.open(axis_kind(joint), fmt::format(" sid=\"axis{}\"", i));
      text.leaf("axis", "", numbers_text(axes[i]));
      const std::optional<double> lower = is_moved(joint) ? joint.lower : 0,
                                  upper = is_moved(joint) ? joint.upper : 0;
      // ROS's reader ends at a limit on one side.
      if (lower && upper && joint.kind != Kind::kBall) {
        text.open("limits");
        text.leaf("min", "", limit_text(joint, *lower));
        text.leaf("max", "", limit_text(joint, *upper));
        text.close();
      }
      text.close();
    }
    text.close();
  }

  void write_link(std::size_t link, const JointDescription* joint, ColladaText& text) {
    const LinkDescription& its = robot_.links[link];
    text.open("link",
              fmt::format(" sid=\"link{}\"", link) + xml_attribute("name", link_names_[link]));
    if (joint && !joint->X_JC.isApprox(RigidTransform::Identity(), 0)) text.steps(joint->X_JC);
    for (const std::size_t below : below_[its.name]) {
      const JointDescription& next = robot_.joints[below];
      text.open("attachment_full", xml_attribute("joint", "kmodel0/" + joint_sid(below)));
      text.steps(next.X_PJ);
      write_link(number_of_link_.at(next.child), &next, text);
      text.close();
    }
    text.close();
  }

  /// multiplier * leader + offset, in radians and metres. OpenRAVE takes velocities by the partial
  /// derivatives of its own technique.
  void write_formula(std::size_t number, ColladaText& text) {
    if (!leader_of(robot_.joints[number])) return;
    const Follows follows = coupling_line(robot_, robot_.joints[number]).line;
    const std::string leader = "kmodel0/" + joint_sid(number_of_joint_.at(follows.joint));
    const auto open_math = [&] {
      text.open("math", " xmlns=\"http://www.w3.org/1998/Math/MathML\"");
    };
    const auto write_position = [&] {
      open_math();
      text.open("apply");
      text.leaf("plus", "");
      text.open("apply");
      text.leaf("times", "");
      text.leaf("cn", "", number_text(follows.multiplier()));
      text.leaf("csymbol", " encoding=\"COLLADA\"", leader);
      text.close();
      text.leaf("cn", "", number_text(follows.offset()));
      text.close();
      text.close();
    };
    text.open("formula", xml_attribute("sid", joint_sid(number) + "_formula"));
    text.open("target");
    text.leaf("param", "", "kmodel0/" + joint_sid(number));
    text.close();
    text.open("technique_common");
    write_position();
    text.close();
    text.open("technique", " profile=\"OpenRAVE\"");
    text.open("equation", " type=\"position\"");
    write_position();
    text.close();
    for (const auto& [type, value] :
         {std::pair{"first_partial", follows.multiplier()}, std::pair{"second_partial", 0.0}}) {
      text.open("equation", xml_attribute("type", type) + xml_attribute("target", leader));
      open_math();
      text.leaf("cn", "", number_text(value));
      text.close();
      text.close();
    }
    text.close();
    text.close();
  }

  /// Of each axis its joint's and its own number, and its name in parameters.
  std::vector<std::tuple<std::size_t, int, std::string>> axes() const {
    std::vector<std::tuple<std::size_t, int, std::string>> all;
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      const int count = static_cast<int>(axes_of(robot_.joints[i]).size());
      for (int k = 0; k < count; ++k) all.emplace_back(i, k, axis_sid(i, k));
    }
    return all;
  }

  // The articulated systems: what moves by itself, and how fast.
  std::string systems() {
    ColladaText text(1);
    text.open("library_articulated_systems");
    write_kinematics_system(text);
    write_motion_system(text);
    text.close();
    text.open("library_kinematics_scenes");
    text.open("kinematics_scene", " id=\"kscene\"");
    text.open("instance_articulated_system",
              " sid=\"motion_inst\" url=\"#motion\"" + xml_attribute("name", robot_.name));
    write_bind("scene_model", "motion/motion_model", text);
    for (const auto& [joint, axis, name] : axes()) {
      write_bind("scene_" + name, "motion/motion_" + name, text);
      write_bind("scene_" + name + "_value", "motion/motion_" + name + "_value", text);
    }
    for (int i = 0; i < 3; ++i) text.close();
    return text.take();
  }

  static void write_bind(const std::string& symbol, const std::string& target, ColladaText& text) {
    text.open("bind", xml_attribute("symbol", symbol));
    text.leaf("param", xml_attribute("ref", target));
    text.close();
  }

  static void write_parameter(const std::string& sid, const char* kind, const std::string& value,
                              ColladaText& text) {
    text.open("newparam", xml_attribute("sid", sid));
    text.leaf(kind, "", value);
    text.close();
  }

  void write_kinematics_system(ColladaText& text) {
    text.open("articulated_system", " id=\"kinematics\"");
    text.open("kinematics");
    text.open("instance_kinematics_model", " url=\"#kmodel0\" sid=\"kmodel0_inst\"");
    write_parameter("kinematics_model", "SIDREF", "kinematics/kmodel0_inst", text);
    for (const auto& [joint, axis, name] : axes()) {
      write_parameter("kinematics_" + name, "SIDREF",
                      fmt::format("kinematics/kmodel0_inst/joint{}/axis{}", joint, axis), text);
      write_parameter("kinematics_" + name + "_value", "float", "0", text);
    }
    text.close();
    text.open("technique_common");
    for (const auto& [number, axis, name] : axes()) {
      const JointDescription& joint = robot_.joints[number];
      text.open("axis_info",
                xml_attribute("sid", "info_" + name) +
                    xml_attribute("axis", fmt::format("kmodel0/joint{}/axis{}", number, axis)));
      const bool moves = is_moved(joint);
      for (const auto& [element, is_so] :
           {std::pair{"active", moves && !joint.passive && !leader_of(joint)},
            std::pair{"locked", !moves}}) {
        text.open(element);
        text.leaf("bool", "", is_so ? "true" : "false");
        text.close();
      }
      text.close();
    }
    for (int i = 0; i < 3; ++i) text.close();
  }

  void write_motion_system(ColladaText& text) {
    text.open("articulated_system", " id=\"motion\"");
    text.open("motion");
    text.open("instance_articulated_system", " url=\"#kinematics\"");
    write_parameter("motion_model", "SIDREF", "kinematics/kinematics_model", text);
    for (const auto& [joint, axis, name] : axes()) {
      for (const char* what : {"", "_value"}) {
        write_parameter("motion_" + name + what, "SIDREF", "kinematics/kinematics_" + name + what,
                        text);
      }
    }
    text.close();
    text.open("technique_common");
    for (const auto& [number, axis, name] : axes()) {
      const JointDescription& joint = robot_.joints[number];
      if (!joint.velocity || !is_moved(joint)) continue;
      text.open("axis_info", xml_attribute("axis", "kinematics/info_" + name));
      text.open("speed");
      text.leaf("float", "", limit_text(joint, *joint.velocity));
      text.close();
      text.close();
    }
    text.close();
    text.close();
    write_system_extras(robot_, text);
    text.close();
  }

  // Masses and what is touched.
  std::string physics(const std::map<std::string, RigidTransform>& X_RL) {
    ColladaText text(1);
    text.open("library_physics_models");
    text.open("physics_model", " id=\"pmodel0\"" + xml_attribute("name", robot_.name));
    shapes_.write_bodies(X_RL, text);
    text.close();
    text.close();
    text.open("library_physics_scenes");
    text.open("physics_scene", " id=\"pscene\"");
    text.open("instance_physics_model",
              " url=\"#pmodel0\" sid=\"pmodel0_inst\" parent=\"#visual0\"");
    for (const auto& [link, sid] : shapes_.bodies()) {
      text.leaf("instance_rigid_body",
                xml_attribute("body", sid) +
                    xml_attribute("target", fmt::format("#node{}", number_of_link_.at(link))));
    }
    text.close();
    text.leaf("technique_common", "");
    text.close();
    text.close();
    return text.take();
  }

  std::string scene() const {
    ColladaText text(1);
    text.open("scene");
    text.leaf("instance_physics_scene", " url=\"#pscene\"");
    text.leaf("instance_visual_scene", " url=\"#vscene\"");
    text.open("instance_kinematics_scene", " url=\"#kscene\"");
    text.open("bind_kinematics_model",
              xml_attribute("node", fmt::format("visual0/node{}", number_of_link_.at(root_))));
    text.leaf("param", "", "scene_model");
    text.close();
    for (const auto& [number, axis, name] : axes()) {
      const std::size_t link = number_of_link_.at(robot_.joints[number].child);
      text.open("bind_joint_axis", xml_attribute("target", fmt::format("node{}/{}", link, name)));
      text.open("axis");
      text.leaf("param", "", "scene_" + name);
      text.close();
      text.open("value");
      text.leaf("param", "", "scene_" + name + "_value");
      text.close();
      text.close();
    }
    text.close();
    text.close();
    return text.take();
  }

  const RobotDescription& robot_;
  ColladaShapeWriter shapes_;
  std::string root_;
  std::map<std::string, std::size_t> number_of_joint_, number_of_link_;
  std::vector<std::string> joint_names_, link_names_;      // as they are written
  std::map<std::string, std::vector<std::size_t>> below_;  // joints, by the link above
};

}  // namespace

std::string collada_text(const RobotDescription& robot, LossReport& loss) {
  std::string text = ColladaWriter(robot).text();
  tell_collada_losses(robot, loss);
  return text;
}

}  // namespace prehend::robot::formats
