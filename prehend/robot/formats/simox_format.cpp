// Simox's (VirtualRobot's) robots, as KIT's ARMAR-III and others' hands are described
// (TheMarex/simox, its reader): nodes with a pose and a joint each, in millimetres, names in any
// case.

#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/tracked_xml.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using Kind = JointDescription::Kind;

constexpr double kMilli = 1e-3;
constexpr double kRadPerDegree = std::numbers::pi / 180;

/// The unit that any of an element's attributes for it says.
double unit_of(const XmlElement& element, std::initializer_list<const char*> attributes,
               double otherwise) {
  static const std::map<std::string, double> kUnits{{"mm", kMilli},
                                                    {"m", 1},
                                                    {"degree", kRadPerDegree},
                                                    {"deg", kRadPerDegree},
                                                    {"radian", 1},
                                                    {"rad", 1},
                                                    {"kg", 1},
                                                    {"g", kMilli},
                                                    {"t", 1e3}};
  for (const char* name : attributes) {
    const auto word = element.attribute(name);
    if (!word) continue;
    const auto found = kUnits.find(*word);
    if (found == kUnits.end()) element.fail("the unit '" + *word + "' is not known", "Mend it");
    otherwise = found->second;
  }
  return otherwise;
}

double length_unit(const XmlElement& element) {
  return unit_of(element, {"unit", "units", "unitslength"}, kMilli);
}
double angle_unit(const XmlElement& element) {
  return unit_of(element, {"unit", "units", "unitsangle"}, 1);
}

Eigen::Vector3d xyz_of(const XmlElement& element) {
  return {element.number("x").value_or(0), element.number("y").value_or(0),
          element.number("z").value_or(0)};
}

bool is_word(const std::string& name, const char* word) {
  return std::equal(name.begin(), name.end(), word, word + std::char_traits<char>::length(word),
                    [](char a, char b) { return std::tolower(a) == std::tolower(b); });
}

RigidTransform simox_transform(const XmlElement& element) {
  RigidTransform X = RigidTransform::Identity();
  for (const XmlElement& step : element.children()) {
    const std::string name = step.name();
    if (is_word(name, "Translation")) {
      X.translate(length_unit(step) * xyz_of(step));
    } else if (is_word(name, "rollpitchyaw") || is_word(name, "rpy")) {
      const double unit = angle_unit(step);
      X = X * from_roll_pitch_yaw(Eigen::Vector3d::Zero(),
                                  unit * Eigen::Vector3d(step.number("roll").value_or(0),
                                                         step.number("pitch").value_or(0),
                                                         step.number("yaw").value_or(0)));
    } else if (is_word(name, "quat") || is_word(name, "quaternion")) {
      X.rotate(Eigen::Quaterniond(step.needed_number("w"), step.needed_number("x"),
                                  step.needed_number("y"), step.needed_number("z"))
                   .normalized());
    } else if (is_word(name, "DH")) {
      const double length = unit_of(step, {"unitslength"}, kMilli);
      const double angle = unit_of(step, {"unitsangle"}, 1);
      X.rotate(
          Eigen::AngleAxisd(angle * step.number("theta").value_or(0), Eigen::Vector3d::UnitZ()));
      X.translate(length * Eigen::Vector3d(0, 0, step.number("d").value_or(0)));
      X.translate(length * Eigen::Vector3d(step.number("a").value_or(0), 0, 0));
      X.rotate(
          Eigen::AngleAxisd(angle * step.number("alpha").value_or(0), Eigen::Vector3d::UnitX()));
    } else if (is_word(name, "matrix4x4") || is_word(name, "matrix3x3")) {
      const bool has_place = is_word(name, "matrix4x4");
      Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
      for (int row = 0; row < (has_place ? 4 : 3); ++row) {
        const auto line = step.child(fmt::format("row{}", row + 1).c_str());
        if (!line) step.fail("the matrix has no row " + std::to_string(row + 1), "Give it");
        for (int column = 0; column < (has_place ? 4 : 3); ++column) {
          M(row, column) = line->needed_number(fmt::format("c{}", column + 1).c_str());
        }
      }
      RigidTransform given = RigidTransform::Identity();
      given.linear() = Eigen::Quaterniond(Eigen::Matrix3d(M.topLeftCorner<3, 3>()))
                           .normalized()
                           .toRotationMatrix();
      given.translation() = length_unit(step) * M.topRightCorner<3, 1>();
      X = X * given;
    } else {
      step.drop("no step of a transform");
    }
  }
  return X;
}

class SimoxReader {
 public:
  explicit SimoxReader(LossReport& loss) : loss_(loss) {}

  /// @returns the file's root node
  std::string read_file(const std::filesystem::path& file, int depth) {
    files_.spend(file);
    TrackedXml document = TrackedXml::read(file, loss_);
    document.ignore_case();
    const XmlElement root = document.root();
    if (depth > 16) root.fail("files of robots are in a ring", "Leave one ChildFromRobot away");
    if (robot_.name.empty()) robot_.name = root.attribute("Type").value_or(file.stem().string());
    root.attribute("Type");
    root.attribute("StandardName");
    const std::string first = root.needed("RootNode");
    for (const XmlElement& node : root.children("RobotNode")) read_node(node, file, depth);
    for (const XmlElement& one : root.children("RobotNodeSet")) {
      one.drop("sets of nodes are not kept");
    }
    for (const XmlElement& one : root.children("Endeffector")) {
      read_endeffector(one);
    }
    document.finish();
    return first;
  }

  RobotDescription finish(const std::string& root) {
    for (auto& [child, parent] : parents_) {
      const auto found = joints_.find(child);
      if (found == joints_.end()) continue;
      found->second.parent = parent;
    }
    // The root first, and nodes in the order of their files.
    std::stable_partition(robot_.links.begin(), robot_.links.end(),
                          [&](const LinkDescription& link) { return link.name == root; });
    for (const LinkDescription& link : robot_.links) {
      if (link.name == root) continue;
      robot_.joints.push_back(joints_.at(link.name));
    }
    for (const auto& [manipulator, place] : endeffectors_) {
      const auto is_there = [&](const std::string& link) { return robot_.link(link) != nullptr; };
      if (is_there(manipulator.base) && is_there(manipulator.tip)) {
        robot_.manipulators.push_back(manipulator);
      } else {
        loss_.drop(place, "Endeffector '" + manipulator.name + "'", "its nodes are not there");
      }
    }
    for (const auto& [follower, follows] : follows_) {
      for (JointDescription& joint : robot_.joints) {
        if (joint.name == follower) joint.follows = follows;
      }
    }
    return std::move(robot_);
  }

 private:
  void read_node(const XmlElement& node, const std::filesystem::path& file, int depth) {
    LinkDescription link;
    link.name = node.needed("name");
    refuse_many_links(robot_.links.size() + 1, node.place());
    JointDescription joint;
    joint.name = joint.child = link.name;
    if (const auto transform = node.child("Transform")) joint.X_PJ = simox_transform(*transform);
    if (const auto one = node.child("Joint")) read_joint(*one, joint);
    if (const auto visual = node.child("Visualization")) {
      visual->attribute("enable");
      read_mesh(*visual, link.visuals);
      if (visual->child("UseAsCollisionModel")) link.collisions = link.visuals;
      if (const auto axes = visual->child("CoordinateAxis")) axes->drop("drawn axes are not kept");
    }
    if (const auto collision = node.child("CollisionModel")) read_mesh(*collision, link.collisions);
    if (const auto physics = node.child("Physics")) read_physics(*physics, link);
    for (const XmlElement& sensor : node.children("Sensor")) {
      robot_.sensors.push_back({sensor.attribute("name").value_or(link.name + "_sensor"),
                                sensor.attribute("type").value_or(""), link.name,
                                RigidTransform::Identity(), Eigen::Vector3d::Zero()});
    }
    for (const XmlElement& child : node.children("Child")) {
      adopt(link.name, child.needed("name"), child);
    }
    robot_.links.push_back(link);
    joints_[link.name] = std::move(joint);
    for (const XmlElement& other : node.children("ChildFromRobot")) {
      for (const XmlElement& one : other.children("File")) {
        one.attribute("importEEF");
        const std::filesystem::path path = file.parent_path() / one.text();
        std::error_code error;
        if (!std::filesystem::is_regular_file(path, error)) {
          one.drop("the file is not there");
          continue;
        }
        adopt(link.name, read_file(path, depth + 1), one);
      }
    }
  }
  /// Its tool is the node that is called tcp; which way fingers close, it does not say.
  void read_endeffector(const XmlElement& element) {
    Manipulator manipulator;
    manipulator.name = element.attribute("name").value_or("");
    manipulator.base = element.attribute("base").value_or("");
    manipulator.tip = element.attribute("tcp").value_or(manipulator.base);
    element.drop_attribute("gcp", "one frame is kept of an end effector");
    for (const XmlElement& one : element.children()) {
      one.drop("groups of fingers and preshapes are not kept");
    }
    endeffectors_.emplace_back(std::move(manipulator), element.place());
  }
  void adopt(const std::string& parent, const std::string& child, const XmlElement& at) {
    if (!parents_.emplace(child, parent).second) {
      at.fail("'" + child + "' is a child twice", "Leave one away");
    }
  }

  void read_joint(const XmlElement& element, JointDescription& joint) {
    const std::string type = element.attribute("type").value_or("fixed");
    joint.kind = is_word(type, "revolute")    ? Kind::kRevolute
                 : is_word(type, "prismatic") ? Kind::kPrismatic
                                              : Kind::kFixed;
    const bool turns = joint.kind == Kind::kRevolute;
    joint.axis_J = Eigen::Vector3d::UnitZ();
    for (const char* axis : {"Axis", "TranslationDirection"}) {
      const auto one = element.child(axis);
      if (!one) continue;
      if (!(xyz_of(*one).norm() > 1e-9)) one->fail("the axis has no length", "Give a direction");
      joint.axis_J = xyz_of(*one).normalized();
    }
    const double offset = element.number("offset").value_or(0) * (turns ? 1 : kMilli);
    if (turns) joint.X_PJ.rotate(Eigen::AngleAxisd(offset, joint.axis_J));
    if (joint.kind == Kind::kPrismatic) joint.X_PJ.translate(offset * joint.axis_J);
    element.drop_attribute("initialvalue", "where it stands at first");
    if (const auto limits = element.child("Limits")) {
      const double unit = turns ? angle_unit(*limits) : length_unit(*limits);
      if (const auto low = limits->number("lo")) joint.lower = unit * *low;
      if (const auto high = limits->number("hi")) joint.upper = unit * *high;
    }
    if (const auto speed = element.child("MaxVelocity")) {
      joint.velocity =
          speed->number("value").value_or(0) *
          (turns ? unit_of(*speed, {"unitsangle"}, 1) : unit_of(*speed, {"unitslength"}, 1));
    }
    if (const auto torque = element.child("MaxTorque")) {
      joint.effort = torque->number("value").value_or(0);
    }
    if (const auto one = element.child("MaxAcceleration")) one->drop("accelerations are not kept");
    for (const XmlElement& one : element.children("PropagateJointValue")) {
      follows_[one.needed("name")] = Follows{joint.name, one.number("factor").value_or(1), 0};
    }
  }

  static void read_mesh(const XmlElement& element, std::vector<Shape>& shapes) {
    for (const XmlElement& one : element.children("File")) {
      one.attribute("type");
      Shape shape;
      shape.kind = Shape::Kind::kMesh;
      shape.mesh = one.text();
      shapes.push_back(std::move(shape));
    }
  }

  void read_physics(const XmlElement& element, LinkDescription& link) {
    Inertial inertial;
    if (const auto mass = element.child("Mass")) {
      inertial.mass =
          mass->number("value").value_or(0) * unit_of(*mass, {"unit", "units", "unitsweight"}, 1);
    }
    if (const auto center = element.child("CoM")) {
      if (center->attribute("location")) {
        center->approximate("taken at the node's origin: the middle of its shape is not computed");
      } else {
        inertial.X_LI.translation() = length_unit(*center) * xyz_of(*center);
      }
    }
    if (const auto matrix = element.child("InertiaMatrix")) {
      matrix->drop("inertias are not kept of this format");
    }
    if (const auto one = element.child("SimulationType")) one->drop("how it is simulated");
    for (const XmlElement& one : element.children("IgnoreCollision")) {
      robot_.disabled_collisions.emplace_back(link.name, one.needed("name"));
    }
    if (inertial.mass > 0) link.inertial = inertial;
  }

  LossReport& loss_;
  FileBudget files_;
  RobotDescription robot_;
  std::map<std::string, JointDescription> joints_;                 // by node
  std::map<std::string, std::string> parents_;                     // by child
  std::map<std::string, Follows> follows_;                         // by follower
  std::vector<std::pair<Manipulator, std::string>> endeffectors_;  // and their places
};

class Simox : public RobotFormat {
 public:
  std::string name() const override { return "simox"; }
  std::string ending() const override { return ".xml"; }
  bool recognises(const XmlElement& root) const override {
    return is_word(root.name(), "Robot") && root.attribute("RootNode");
  }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    SimoxReader reader(loss);
    const std::string root = reader.read_file(file, 0);
    RobotDescription robot = reader.finish(root);
    tree_order(robot);
    return robot;
  }
};

}  // namespace

std::unique_ptr<RobotFormat> simox_format() { return std::make_unique<Simox>(); }

}  // namespace prehend::robot::formats
