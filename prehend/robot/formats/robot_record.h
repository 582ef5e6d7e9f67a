#pragma once

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "prehend/robot/formats/json_record.h"
#include "prehend/robot/formats/robot_description.h"

// A description's records as JSON, each field named once: docs/models.md names every key. Both
// prehend's own text and its extension of other formats are made of them.
namespace prehend::robot::formats {

namespace record {

inline const geometry::RigidTransform kIdentity = geometry::RigidTransform::Identity();
inline const Eigen::Vector3d kZero = Eigen::Vector3d::Zero();
inline const Eigen::Vector3d kOnes = Eigen::Vector3d::Ones();
inline const Eigen::Vector3d kUnitX = Eigen::Vector3d::UnitX();

// In the order of the enums.
inline constexpr std::array kShapeKinds{"box", "sphere", "cylinder", "capsule", "plane", "mesh"};
inline constexpr std::array kJointKinds{"fixed", "revolute", "prismatic",
                                        "ball",  "floating", "planar"};
inline constexpr std::array kLoopKinds{"point", "weld"};

}  // namespace record

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Inertial>& inertial) {
  v.field("mass", inertial.mass);
  v.field("pose", inertial.X_LI, record::kIdentity);
  v.field("inertia", inertial.inertia);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Shape>& shape) {
  v.field("name", shape.name, std::string());
  v.choice("kind", shape.kind, record::kShapeKinds);
  v.field("pose", shape.X_LS, record::kIdentity);
  v.field("size", shape.size, record::kZero);
  v.field("radius", shape.radius, 0.0);
  v.field("length", shape.length, 0.0);
  v.field("mesh", shape.mesh, std::string());
  v.field("scale", shape.scale, record::kOnes);
  v.field("material", shape.material, std::string());
  v.field("color", shape.color);
  if constexpr (!Visitor::kReads) {
    if (shape.surface) v.loss().drop(v.path(), "mesh '" + shape.mesh + "'", "it is no file's");
  }
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, LinkDescription>& link) {
  v.field("name", link.name);
  v.field("inertial", link.inertial);
  v.list("visuals", link.visuals);
  v.list("collisions", link.collisions);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Follows>& follows) {
  v.field("joint", follows.joint);
  // A line by two words, all else by its coefficients.
  double multiplier = 1, offset = 0;
  std::vector<double> coefficients;
  if constexpr (!Visitor::kReads) {
    if (follows.is_linear()) {
      multiplier = follows.multiplier();
      offset = follows.offset();
    } else {
      coefficients = follows.coefficients;
    }
  }
  v.field("multiplier", multiplier, 1.0);
  v.field("offset", offset, 0.0);
  v.list("coefficients", coefficients);
  if constexpr (Visitor::kReads) {
    follows.coefficients = {offset, multiplier};
    if (coefficients.empty()) return;
    constexpr std::size_t kMost = 16;
    if (coefficients.size() < 2 || coefficients.size() > kMost) {
      v.fail(v.path() + ".coefficients", "is no list of 2 to 16 numbers", "Write so many");
    }
    if (multiplier != 1 || offset != 0) {
      v.fail(v.path(), "has coefficients beside multiplier or offset", "Leave one of them away");
    }
    while (coefficients.size() > 2 && coefficients.back() == 0) coefficients.pop_back();
    follows.coefficients = std::move(coefficients);
  }
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, JointDescription>& joint) {
  v.field("name", joint.name);
  v.choice("kind", joint.kind, record::kJointKinds);
  v.field("parent", joint.parent);
  v.field("child", joint.child);
  v.field("pose", joint.X_PJ, record::kIdentity);
  v.field("child_pose", joint.X_JC, record::kIdentity);
  v.field("axis", joint.axis_J, record::kUnitX);
  v.field("lower", joint.lower);
  v.field("upper", joint.upper);
  v.field("velocity", joint.velocity);
  v.field("effort", joint.effort);
  v.field("damping", joint.damping, 0.0);
  v.field("friction", joint.friction, 0.0);
  v.field("stiffness", joint.stiffness);
  v.field("rest", joint.rest, 0.0);
  v.field("follows", joint.follows);
  v.field("break_away", joint.break_away);
  v.field("passive", joint.passive, false);
  if constexpr (Visitor::kReads) {
    const double length = joint.axis_J.norm();
    constexpr double kRounded = 1e-9;
    if (!(length > kRounded)) v.fail(v.path() + ".axis", "has no length", "Give a direction");
    if (std::abs(length - 1) > kRounded) {
      joint.axis_J /= length;
      v.loss().approximate(v.path(), "axis", "it was made a unit vector");
    }
  }
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Loop>& loop) {
  v.field("name", loop.name);
  v.choice("kind", loop.kind, record::kLoopKinds);
  v.field("first", loop.first);
  v.field("second", loop.second);
  v.field("pose", loop.X_FirstLoop, record::kIdentity);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Actuator>& actuator) {
  v.field("name", actuator.name);
  v.field("joint", actuator.joint);
  v.field("gear", actuator.gear, 1.0);
  v.field("effort", actuator.effort);
  v.field("control", actuator.control, std::string());
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Sensor>& sensor) {
  v.field("name", sensor.name);
  v.field("kind", sensor.kind);
  v.field("link", sensor.link);
  v.field("pose", sensor.X_LS, record::kIdentity);
  v.field("size", sensor.size, record::kZero);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Manipulator>& manipulator) {
  v.field("name", manipulator.name);
  v.field("base", manipulator.base);
  v.field("tip", manipulator.tip);
  v.field("tool", manipulator.X_TipTool, record::kIdentity);
  v.list("closing", manipulator.closing);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Posture>& posture) {
  v.field("name", posture.name);
  v.field("group", posture.group, std::string());
  v.field("positions", posture.positions);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, RobotDescription>& robot) {
  v.field("name", robot.name);
  v.list("links", robot.links);
  v.list("joints", robot.joints);
  v.list("loops", robot.loops);
  v.list("actuators", robot.actuators);
  v.list("sensors", robot.sensors);
  v.list("manipulators", robot.manipulators);
  v.list("postures", robot.postures);
  v.list("disabled_collisions", robot.disabled_collisions);
}

}  // namespace prehend::robot::formats
