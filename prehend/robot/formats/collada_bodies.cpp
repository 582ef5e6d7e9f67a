#include "prehend/robot/formats/collada_bodies.h"

#include <map>
#include <optional>
#include <utility>

#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_shapes.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using AxisJoint = std::function<const JointDescription*(const std::string& axis)>;

/// Where links are in the root's frame, all joints at 0, also those that follow.
ColladaLinks links_at_zero(const RobotDescription& robot, const AxisJoint& joint_of) {
  RobotDescription at_zero = robot;
  for (JointDescription& joint : at_zero.joints) joint.follows.reset();
  ColladaLinks links;
  links.X_RL = link_poses(at_zero, {});
  links.root = roots(robot).front();
  links.moved_by = [&joint_of](const std::string& axis) {
    const JointDescription* joint = joint_of(axis);
    return joint ? joint->child : std::string();
  };
  return links;
}

void read_mass(const XmlElement& technique, const RigidTransform& X_LR, double length,
               LinkDescription& link) {
  Inertial inertial;
  inertial.mass = number_in(technique.child("mass")).value_or(0);
  technique.child("dynamic");
  RigidTransform X_MI = RigidTransform::Identity();
  if (const auto frame = technique.child("mass_frame")) X_MI = collada_steps(*frame, length);
  inertial.X_LI = X_LR * X_MI;
  if (const auto inertia = technique.child("inertia")) {
    const auto n = inertia->text_numbers(3);
    inertial.inertia = Eigen::Vector3d(n[0], n[1], n[2]).asDiagonal();
  }
  constexpr double kUnknown = 1e-9;  // kg: what is written for no mass
  if (inertial.mass > kUnknown) link.inertial = inertial;
}

/// The link of each rigid body, by the body's sid.
std::map<std::string, std::string> links_of_bodies(TrackedXml& document, const XmlElement& library,
                                                   const ColladaShapes& shapes,
                                                   const RobotDescription& robot) {
  std::map<std::string, std::string> link_of;  // by rigid body
  const auto tie = [&](const XmlElement& holder) {
    for (const XmlElement& one : holder.children("instance_rigid_body")) {
      std::string target = one.attribute("target").value_or("");
      if (target.starts_with("#")) target.erase(0, 1);
      std::string name = shapes.link_of_node(target);
      const auto node = name.empty() ? document.by_id(target) : std::nullopt;
      if (node) name = node->attribute("name").value_or("");
      if (robot.link(name)) link_of[one.attribute("body").value_or("")] = name;
    }
  };
  if (const auto scenes = document.root().child("library_physics_scenes")) {
    for (const XmlElement& scene : scenes->children("physics_scene")) {
      know_names(scene);
      scene.child("technique_common");
      for (const XmlElement& one : scene.children("instance_physics_model")) {
        know_names(one);
        one.attribute("parent");
        tie(one);
      }
    }
  }
  for (const XmlElement& model : library.children("physics_model")) {
    know_names(model);
    for (const XmlElement& one : model.children("instance_physics_model")) tie(one);
  }
  return link_of;
}

}  // namespace

void read_collada_bodies(TrackedXml& document, double length, const AxisJoint& joint_of,
                         RobotDescription& robot) {
  const ColladaLinks links = links_at_zero(robot, joint_of);
  ColladaShapes shapes(document, length);
  shapes.read_visuals(links, robot);
  const auto library = document.root().child("library_physics_models");
  if (!library) return;
  const auto link_of = links_of_bodies(document, *library, shapes, robot);
  for (const XmlElement& model : library->children("physics_model")) {
    for (const XmlElement& body : model.children("rigid_body")) {
      know_names(body);
      const std::string sid = body.attribute("sid").value_or("");
      const auto found = link_of.find(sid);
      const std::string name =
          found != link_of.end() ? found->second : body.attribute("name").value_or("");
      const auto technique = body.child("technique_common");
      if (!robot.link(name) || !technique) {
        body.drop("no link is tied to it");
        continue;
      }
      // Its frames are in the root's, not in its link's.
      const RigidTransform X_LR = links.X_RL.at(name).inverse();
      for (LinkDescription& link : robot.links) {
        if (link.name != name) continue;
        read_mass(*technique, X_LR, length, link);
        auto solids = shapes.read_body(*technique, X_LR, name);
        if (!solids.empty()) link.collisions = std::move(solids);
      }
    }
  }
}

}  // namespace prehend::robot::formats
