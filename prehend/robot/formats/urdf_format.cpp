// URDF (http://wiki.ros.org/urdf/XML), read and written.

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/srdf.h"
#include "prehend/robot/formats/tracked_xml.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using Kind = JointDescription::Kind;

Eigen::Vector3d vector_of(const XmlElement& element, const char* name,
                          const Eigen::Vector3d& otherwise) {
  const auto numbers = element.numbers(name, 3);
  return numbers ? Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]) : otherwise;
}

RigidTransform origin_of(const XmlElement& element) {
  const auto origin = element.child("origin");
  if (!origin) return RigidTransform::Identity();
  return from_roll_pitch_yaw(vector_of(*origin, "xyz", Eigen::Vector3d::Zero()),
                             vector_of(*origin, "rpy", Eigen::Vector3d::Zero()));
}

struct Colors {
  std::map<std::string, std::array<double, 4>> by_name;
};

std::optional<std::array<double, 4>> color_of(const XmlElement& material) {
  const auto color = material.child("color");
  if (!color) return std::nullopt;
  const auto rgba = color->numbers("rgba", 4);
  if (!rgba) return std::nullopt;
  return std::array<double, 4>{(*rgba)[0], (*rgba)[1], (*rgba)[2], (*rgba)[3]};
}

std::optional<Shape> read_urdf_shape(const XmlElement& element, const Colors& colors) {
  Shape shape;
  shape.name = element.attribute("name").value_or("");
  shape.X_LS = origin_of(element);
  const auto geometry = element.child("geometry");
  if (!geometry) element.fail("<" + element.name() + "> has no geometry", "Give one");
  if (const auto box = geometry->child("box")) {
    shape.kind = Shape::Kind::kBox;
    if (!box->attribute("size")) box->fail("<box> has no size", "Give it");
    shape.size = vector_of(*box, "size", {});
  } else if (const auto sphere = geometry->child("sphere")) {
    shape.kind = Shape::Kind::kSphere;
    shape.radius = sphere->needed_number("radius");
  } else if (const auto cylinder = geometry->child("cylinder")) {
    shape.kind = Shape::Kind::kCylinder;
    shape.radius = cylinder->needed_number("radius");
    shape.length = cylinder->needed_number("length");
  } else if (const auto capsule = geometry->child("capsule")) {
    shape.kind = Shape::Kind::kCapsule;
    shape.radius = capsule->needed_number("radius");
    shape.length = capsule->needed_number("length");
  } else if (const auto mesh = geometry->child("mesh")) {
    shape.kind = Shape::Kind::kMesh;
    shape.mesh = mesh->needed("filename");
    shape.scale = vector_of(*mesh, "scale", Eigen::Vector3d::Ones());
  } else {
    geometry->drop("it is none of box, sphere, cylinder, capsule, mesh");
    return std::nullopt;
  }
  if (const auto material = element.child("material")) {
    shape.material = material->attribute("name").value_or("");
    shape.color = color_of(*material);
    const auto known = colors.by_name.find(shape.material);
    if (!shape.color && known != colors.by_name.end()) shape.color = known->second;
    if (const auto texture = material->child("texture")) {
      texture->drop("textures are not kept");
    }
  }
  return shape;
}

LinkDescription read_urdf_link(const XmlElement& element, const Colors& colors) {
  LinkDescription link;
  link.name = element.needed("name");
  if (const auto inertial = element.child("inertial")) {
    link.inertial.emplace();
    link.inertial->X_LI = origin_of(*inertial);
    if (const auto mass = inertial->child("mass"))
      link.inertial->mass = mass->needed_number("value");
    if (const auto inertia = inertial->child("inertia")) {
      const auto at = [&](const char* name) { return inertia->number(name).value_or(0); };
      const double xy = at("ixy"), xz = at("ixz"), yz = at("iyz");
      // All are read before: an assertion of Eigen's forbids to throw half way.
      const double xx = at("ixx"), yy = at("iyy"), zz = at("izz");
      link.inertial->inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    }
  }
  for (const XmlElement& one : element.children("visual")) {
    if (auto shape = read_urdf_shape(one, colors)) link.visuals.push_back(std::move(*shape));
  }
  for (const XmlElement& one : element.children("collision")) {
    if (auto shape = read_urdf_shape(one, colors)) link.collisions.push_back(std::move(*shape));
  }
  return link;
}

Kind kind_of(const XmlElement& element, bool& is_continuous) {
  const std::string type = element.needed("type");
  is_continuous = type == "continuous";
  const std::map<std::string, Kind> kinds{
      {"fixed", Kind::kFixed},         {"revolute", Kind::kRevolute},
      {"continuous", Kind::kRevolute}, {"prismatic", Kind::kPrismatic},
      {"floating", Kind::kFloating},   {"planar", Kind::kPlanar}};
  const auto found = kinds.find(type);
  if (found == kinds.end()) {
    element.fail("joint type '" + type + "' is none of URDF's",
                 "Write fixed, revolute, continuous, prismatic, floating or planar");
  }
  return found->second;
}

JointDescription read_joint(const XmlElement& element) {
  JointDescription joint;
  joint.name = element.needed("name");
  bool is_continuous = false;
  joint.kind = kind_of(element, is_continuous);
  joint.X_PJ = origin_of(element);
  const auto link_of = [&](const char* which) {
    const auto end = element.child(which);
    if (!end) element.fail("joint '" + joint.name + "' has no " + which, "Name a link");
    return end->needed("link");
  };
  joint.parent = link_of("parent");
  joint.child = link_of("child");
  if (const auto axis = element.child("axis")) {
    const Eigen::Vector3d xyz = vector_of(*axis, "xyz", Eigen::Vector3d::UnitX());
    if (joint.kind != Kind::kFixed) {
      if (!(xyz.norm() > 1e-9)) axis->fail("the axis has no length", "Give a direction");
      if (std::abs(xyz.norm() - 1) > 1e-6) axis->approximate("it was made a unit vector");
      joint.axis_J = xyz.normalized();
    }
  }
  if (const auto limit = element.child("limit")) {
    const double lower = limit->number("lower").value_or(0);
    const double upper = limit->number("upper").value_or(0);
    if (!is_continuous && joint.kind != Kind::kFixed) {
      joint.lower = lower;
      joint.upper = upper;
    }
    joint.effort = limit->number("effort");
    joint.velocity = limit->number("velocity");
  }
  if (const auto dynamics = element.child("dynamics")) {
    joint.damping = dynamics->number("damping").value_or(0);
    joint.friction = dynamics->number("friction").value_or(0);
  }
  if (const auto mimic = element.child("mimic")) {
    joint.follows = Follows{mimic->needed("joint"), mimic->number("multiplier").value_or(1),
                            mimic->number("offset").value_or(0)};
  }
  if (const auto safety = element.child("safety_controller")) {
    safety->drop("soft limits are the controller's");
  }
  if (const auto calibration = element.child("calibration")) {
    calibration->drop("reference positions are the controller's");
  }
  return joint;
}

void read_transmission(const XmlElement& element, RobotDescription& robot) {
  const auto joint = element.child("joint");
  const auto motor = element.child("actuator");
  if (!joint || !motor) return element.drop("it joins no motor and joint");
  Actuator actuator;
  actuator.joint = joint->needed("name");
  actuator.name = motor->attribute("name").value_or(actuator.joint);
  std::optional<XmlElement> gear = motor->child("mechanicalReduction");
  if (!gear) gear = element.child("mechanicalReduction");
  if (gear) actuator.gear = gear->text_number();
  std::optional<XmlElement> kind = joint->child("hardwareInterface");
  if (!kind) kind = motor->child("hardwareInterface");
  if (kind) {
    for (const char* word : {"Position", "Velocity", "Effort"}) {
      if (kind->text().find(word) != std::string::npos) {
        actuator.control = std::string(word) == "Position"   ? "position"
                           : std::string(word) == "Velocity" ? "velocity"
                                                             : "effort";
      }
    }
  }
  element.child("type");
  element.attribute("name");
  robot.actuators.push_back(std::move(actuator));
}

class UrdfWriter {
 public:
  UrdfWriter(const RobotDescription& robot, LossReport& loss) : robot_(robot), loss_(loss) {}

  std::string write() {
    line(0, "<?xml version=\"1.0\"?>");
    line(0, fmt::format("<robot name=\"{}\">", escaped(robot_.name)));
    for (const LinkDescription& link : robot_.links) write_link(link);
    for (const JointDescription& joint : robot_.joints) write_joint(joint);
    for (const Actuator& actuator : robot_.actuators) write_actuator(actuator);
    line(0, "</robot>");
    for (const Loop& loop : robot_.loops) {
      loss_.drop("loop '" + loop.name + "'", "loop", "URDF has trees alone");
    }
    for (const Sensor& sensor : robot_.sensors) {
      loss_.drop("sensor '" + sensor.name + "'", "sensor (" + sensor.kind + ")",
                 "URDF has no sensors");
    }
    for (const Posture& one : robot_.postures) {
      loss_.drop("posture '" + one.name + "'", "posture", "URDF has no postures; SRDF has");
    }
    for (const JointDescription& joint : robot_.joints) {
      if (joint.passive) {
        loss_.drop("joint '" + joint.name + "'", "passive joint", "it is an SRDF's");
      }
    }
    for (const Manipulator& one : robot_.manipulators) {
      loss_.drop("manipulator '" + one.name + "'", "manipulator",
                 "URDF has no manipulators; SRDF has");
    }
    if (!robot_.disabled_collisions.empty()) {
      loss_.drop("robot",
                 fmt::format("{} pairs of links that may touch", robot_.disabled_collisions.size()),
                 "they are an SRDF's");
    }
    return std::move(text_);
  }

 private:
  void line(int depth, const std::string& words) {
    text_.append(2 * static_cast<std::size_t>(depth), ' ').append(words).push_back('\n');
  }
  void origin(int depth, const RigidTransform& X) {
    if (X.isApprox(RigidTransform::Identity(), 0)) return;
    line(depth, fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", numbers_text(X.translation()),
                            numbers_text(roll_pitch_yaw(X.linear()))));
  }
  void write_link(const LinkDescription& link) {
    loss_.keep("link");
    line(1, fmt::format("<link name=\"{}\">", escaped(link.name)));
    if (link.inertial) {
      line(2, "<inertial>");
      origin(3, link.inertial->X_LI);
      line(3, fmt::format("<mass value=\"{}\"/>", number_text(link.inertial->mass)));
      const Eigen::Matrix3d& I = link.inertial->inertia;
      line(3, fmt::format("<inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" "
                          "izz=\"{}\"/>",
                          number_text(I(0, 0)), number_text(I(0, 1)), number_text(I(0, 2)),
                          number_text(I(1, 1)), number_text(I(1, 2)), number_text(I(2, 2))));
      line(2, "</inertial>");
    }
    for (const Shape& shape : link.visuals) write_shape(link, shape, "visual");
    for (const Shape& shape : link.collisions) write_shape(link, shape, "collision");
    line(1, "</link>");
  }
  static std::string geometry_text(const Shape& shape) {
    switch (shape.kind) {
      case Shape::Kind::kBox:
        return fmt::format("<box size=\"{}\"/>", numbers_text(shape.size));
      case Shape::Kind::kSphere:
        return fmt::format("<sphere radius=\"{}\"/>", number_text(shape.radius));
      case Shape::Kind::kCylinder:
      case Shape::Kind::kCapsule:
        return fmt::format("<cylinder radius=\"{}\" length=\"{}\"/>", number_text(shape.radius),
                           number_text(shape.length));
      case Shape::Kind::kMesh: {
        const bool is_scaled = shape.scale != Eigen::Vector3d::Ones();
        return fmt::format("<mesh filename=\"{}\"{}/>", escaped(shape.mesh),
                           is_scaled ? " scale=\"" + numbers_text(shape.scale) + "\"" : "");
      }
      default:
        return {};
    }
  }
  void write_shape(const LinkDescription& link, const Shape& shape, const char* element) {
    const std::string place = "link '" + link.name + "'";
    if (shape.kind == Shape::Kind::kPlane) {
      return loss_.drop(place, std::string(element) + " (plane)", "URDF has no planes");
    }
    const auto write_one = [&](const Shape& part) {
      loss_.keep(element);
      line(2, part.name.empty() ? fmt::format("<{}>", element)
                                : fmt::format("<{} name=\"{}\">", element, escaped(part.name)));
      origin(3, part.X_LS);
      line(3, "<geometry>" + geometry_text(part) + "</geometry>");
      if (std::string(element) == "visual" && (part.color || !part.material.empty())) {
        const std::string name = part.material.empty() ? "color" : part.material;
        line(3, fmt::format(
                    "<material name=\"{}\">{}</material>", escaped(name),
                    part.color
                        ? fmt::format("<color rgba=\"{} {} {} {}\"/>",
                                      number_text((*part.color)[0]), number_text((*part.color)[1]),
                                      number_text((*part.color)[2]), number_text((*part.color)[3]))
                        : ""));
      }
      line(2, fmt::format("</{}>", element));
    };
    write_one(shape);
    if (shape.kind != Shape::Kind::kCapsule) return;
    loss_.approximate(place, std::string(element) + " (capsule)",
                      "a cylinder and two balls: the same solid");
    for (const double side : {-0.5, 0.5}) {
      Shape ball = shape;
      ball.kind = Shape::Kind::kSphere;
      ball.X_LS.translate(Eigen::Vector3d(0, 0, side * shape.length));
      write_one(ball);
    }
  }
  void write_joint(const JointDescription& joint) {
    loss_.keep("joint");
    const std::string place = "joint '" + joint.name + "'";
    std::string child = joint.child;
    const bool is_apart = !joint.X_JC.isApprox(RigidTransform::Identity(), 0);
    if (is_apart && joint.kind != Kind::kFixed) {
      // The child hangs on a link without mass, where the joint is.
      child = joint.name + "_frame";
      line(1, fmt::format("<link name=\"{}\"/>", escaped(child)));
      line(1, fmt::format("<joint name=\"{}_to_link\" type=\"fixed\">", escaped(joint.name)));
      origin(2, joint.X_JC);
      line(2, fmt::format("<parent link=\"{}\"/>", escaped(child)));
      line(2, fmt::format("<child link=\"{}\"/>", escaped(joint.child)));
      line(1, "</joint>");
    }
    const bool moves = joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
    const bool is_limited = joint.lower && joint.upper;
    const char* type = joint.kind == Kind::kFixed       ? "fixed"
                       : joint.kind == Kind::kRevolute  ? (is_limited ? "revolute" : "continuous")
                       : joint.kind == Kind::kPrismatic ? "prismatic"
                       : joint.kind == Kind::kPlanar    ? "planar"
                                                        : "floating";
    if (joint.kind == Kind::kBall) {
      loss_.approximate(place, "ball joint", "floating: URDF has no balls");
    }
    line(1, fmt::format("<joint name=\"{}\" type=\"{}\">", escaped(joint.name), type));
    origin(2, joint.kind == Kind::kFixed ? joint.X_PJ * joint.X_JC : joint.X_PJ);
    line(2, fmt::format("<parent link=\"{}\"/>", escaped(joint.parent)));
    line(2, fmt::format("<child link=\"{}\"/>", escaped(child)));
    if (moves) line(2, fmt::format("<axis xyz=\"{}\"/>", numbers_text(joint.axis_J)));
    if (moves) write_limit(joint, place, is_limited);
    if (joint.damping != 0 || joint.friction != 0) {
      line(2, fmt::format("<dynamics damping=\"{}\" friction=\"{}\"/>", number_text(joint.damping),
                          number_text(joint.friction)));
    }
    if (joint.follows) {
      const CouplingLine coupling = coupling_line(robot_, joint);
      line(2, fmt::format("<mimic joint=\"{}\" multiplier=\"{}\" offset=\"{}\"/>",
                          escaped(coupling.line.joint), number_text(coupling.line.multiplier()),
                          number_text(coupling.line.offset())));
      if (!joint.follows->is_linear()) {
        loss_.approximate(place, "polynomial coupling", words_of_line(coupling, joint));
      }
    }
    if (joint.break_away) {
      loss_.approximate(place, "break-away clutch", "a mimic that never stays behind");
    }
    if (joint.stiffness) loss_.drop(place, "spring", "URDF has no springs");
    line(1, "</joint>");
  }
  void write_limit(const JointDescription& joint, const std::string& place, bool is_limited) {
    std::string words;
    if (is_limited) {
      words += fmt::format(" lower=\"{}\" upper=\"{}\"", number_text(*joint.lower),
                           number_text(*joint.upper));
    } else if (joint.lower || joint.upper) {
      loss_.drop(place, "limit on one side", "URDF limits both or none");
    }
    if (!is_limited && !joint.effort && !joint.velocity && joint.kind == Kind::kRevolute) return;
    if (!joint.effort || !joint.velocity) {
      loss_.approximate(place, "no limit of effort or velocity",
                        "0 there, which URDF's limit needs and others read as not known");
    }
    if (joint.kind == Kind::kPrismatic && !is_limited) {
      words += " lower=\"-1e9\" upper=\"1e9\"";
      loss_.approximate(place, "slide without limits", "1e9 m, as URDF needs some");
    }
    line(2, fmt::format("<limit{} effort=\"{}\" velocity=\"{}\"/>", words,
                        number_text(joint.effort.value_or(0)),
                        number_text(joint.velocity.value_or(0))));
  }
  void write_actuator(const Actuator& actuator) {
    loss_.keep("actuator");
    line(1, fmt::format("<transmission name=\"{}_transmission\">", escaped(actuator.name)));
    line(2, "<type>transmission_interface/SimpleTransmission</type>");
    const std::string kind = actuator.control == "position"   ? "PositionJointInterface"
                             : actuator.control == "velocity" ? "VelocityJointInterface"
                                                              : "EffortJointInterface";
    line(2, fmt::format("<joint name=\"{}\"><hardwareInterface>hardware_interface/{}"
                        "</hardwareInterface></joint>",
                        escaped(actuator.joint), kind));
    line(2, fmt::format("<actuator name=\"{}\"><mechanicalReduction>{}</mechanicalReduction>"
                        "</actuator>",
                        escaped(actuator.name), number_text(actuator.gear)));
    line(1, "</transmission>");
  }

  const RobotDescription& robot_;
  LossReport& loss_;
  std::string text_;
};

class Urdf : public RobotFormat {
 public:
  std::string name() const override { return "urdf"; }
  bool recognises(const XmlElement& root) const override {
    if (root.name() != "robot") return false;
    for (const XmlElement& one : root.children()) {
      if (one.name() == "link" || one.name().starts_with("xacro:")) return true;
    }
    return false;
  }
  std::string ending() const override { return ".urdf"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    TrackedXml document = TrackedXml::read(file, loss);
    RobotDescription robot = read_robot_element(document.root(), file);
    const auto blocks = document.root().children(kBlock);
    document.finish();
    tree_order(robot);
    // What a URDF cannot say stands beside it, by the same name, and in its block.
    const std::filesystem::path beside = srdf_beside(file);
    std::error_code error;
    if (beside != file && std::filesystem::is_regular_file(beside, error)) {
      read_srdf(beside, robot, loss);
    }
    apply_extension(blocks, robot, loss);
    return robot;
  }
  bool can_write() const override { return true; }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    LossReport written;
    std::string text = UrdfWriter(robot, written).write();
    const auto again = [&] {
      LossReport unused;
      TrackedXml document(text, "robot.urdf", unused);
      RobotDescription plain = read_robot_element(document.root(), "");
      tree_order(plain);
      return plain;
    };
    const std::string block = extension_text(robot, again, written, loss);
    if (!block.empty()) {
      text.insert(text.rfind("</robot>"),
                  fmt::format("  <{0}>{1}</{0}>\n", kBlock, escaped_text(block)));
    }
    return text;
  }

 private:
  static constexpr const char* kBlock = "prehend";

  /// @param file for words, and its name where the robot has none
  static RobotDescription read_robot_element(const XmlElement& root,
                                             const std::filesystem::path& file) {
    RobotDescription robot;
    robot.name = root.attribute("name").value_or(file.stem().string());
    Colors colors;
    for (const XmlElement& material : root.children("material")) {
      if (const auto color = color_of(material)) colors.by_name[material.needed("name")] = *color;
    }
    const auto links = root.children("link"), joints = root.children("joint");
    refuse_many_links(std::max(links.size(), joints.size()), file.string());
    for (const XmlElement& link : links) {
      robot.links.push_back(read_urdf_link(link, colors));
    }
    for (const XmlElement& joint : joints) {
      robot.joints.push_back(read_joint(joint));
    }
    for (const XmlElement& one : root.children("transmission")) read_transmission(one, robot);
    for (const XmlElement& one : root.children("gazebo")) one.drop("it is for Gazebo alone");
    for (const XmlElement& one : root.children()) {
      if (one.name().starts_with("xacro:")) {
        if (one.name() == "xacro:include" || one.name() == "xacro:property") {
          one.drop("macros of xacro are not expanded");
          continue;
        }
        one.fail("<" + one.name() + "> is a macro of xacro", "Expand it: xacro FILE > robot.urdf");
      }
      const std::string word = one.name();
      const bool is_known = word == "link" || word == "joint" || word == "material" ||
                            word == "transmission" || word == "gazebo" || word == kBlock;
      if (!is_known) one.drop("it is none of a robot's elements in URDF");
    }
    return robot;
  }
};

}  // namespace

std::unique_ptr<RobotFormat> urdf_format() { return std::make_unique<Urdf>(); }

}  // namespace prehend::robot::formats
