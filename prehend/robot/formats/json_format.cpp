// prehend's own text of a robot, without a loss: docs/models.md names every key.

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/json_record.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;

constexpr int kVersion = 1;
const RigidTransform kIdentity = RigidTransform::Identity();
const Eigen::Vector3d kZero = Eigen::Vector3d::Zero();
const Eigen::Vector3d kOnes = Eigen::Vector3d::Ones();
const Eigen::Vector3d kUnitX = Eigen::Vector3d::UnitX();

// In the order of the enums.
constexpr std::array kShapeKinds{"box", "sphere", "cylinder", "capsule", "plane", "mesh"};
constexpr std::array kJointKinds{"fixed", "revolute", "prismatic", "ball", "floating", "planar"};
constexpr std::array kLoopKinds{"point", "weld"};

}  // namespace

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Inertial>& inertial) {
  v.field("mass", inertial.mass);
  v.field("pose", inertial.X_LI, kIdentity);
  v.field("inertia", inertial.inertia);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Shape>& shape) {
  v.field("name", shape.name, std::string());
  v.choice("kind", shape.kind, kShapeKinds);
  v.field("pose", shape.X_LS, kIdentity);
  v.field("size", shape.size, kZero);
  v.field("radius", shape.radius, 0.0);
  v.field("length", shape.length, 0.0);
  v.field("mesh", shape.mesh, std::string());
  v.field("scale", shape.scale, kOnes);
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
  v.field("multiplier", follows.multiplier, 1.0);
  v.field("offset", follows.offset, 0.0);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, JointDescription>& joint) {
  v.field("name", joint.name);
  v.choice("kind", joint.kind, kJointKinds);
  v.field("parent", joint.parent);
  v.field("child", joint.child);
  v.field("pose", joint.X_PJ, kIdentity);
  v.field("child_pose", joint.X_JC, kIdentity);
  v.field("axis", joint.axis_J, kUnitX);
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
  v.choice("kind", loop.kind, kLoopKinds);
  v.field("first", loop.first);
  v.field("second", loop.second);
  v.field("pose", loop.X_FirstLoop, kIdentity);
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
  v.field("pose", sensor.X_LS, kIdentity);
  v.field("size", sensor.size, kZero);
}

template <class Visitor>
void fields(Visitor& v, Part<Visitor, Manipulator>& manipulator) {
  v.field("name", manipulator.name);
  v.field("base", manipulator.base);
  v.field("tip", manipulator.tip);
  v.field("tool", manipulator.X_TipTool, kIdentity);
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

namespace {

class OwnJson : public RobotFormat {
 public:
  std::string name() const override { return "json"; }
  bool recognises(const XmlElement&) const override { return false; }
  bool recognises_text(std::string_view head) const override {
    const std::size_t first = head.find_first_not_of(" \t\r\n");
    return first != std::string_view::npos && head[first] == '{';
  }
  std::string ending() const override { return ".json"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    const std::string name = file.string();
    const JsonValue value = parse_json(whole_file(file), name);
    JsonReader reader(value, "", name, loss);
    int version = 0;
    reader.field("prehend_robot", version);
    if (version != kVersion) {
      reader.fail("prehend_robot", std::to_string(version) + " is no version that is known",
                  "This reads version " + std::to_string(kVersion));
    }
    RobotDescription robot;
    fields(reader, robot);
    reader.finish();
    tree_order(robot);
    return robot;
  }
  bool can_write() const override { return true; }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    JsonWriter writer("", loss);
    writer.field("prehend_robot", kVersion);
    fields(writer, robot);
    return json_text(writer.object(), loss);
  }
};

}  // namespace

std::unique_ptr<RobotFormat> json_format() { return std::make_unique<OwnJson>(); }

}  // namespace prehend::robot::formats
