// SDF 1.2 to 1.9 (http://sdformat.org/spec), one model, read; SDF 1.7 written.

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/extension.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/tracked_xml.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
using geometry::RigidTransform;
using Kind = JointDescription::Kind;

constexpr double kWritten = 1.7;     // the version
constexpr double kUnlimited = 1e16;  // SDF's own word for no limit, and what is beyond

double number_in(const XmlElement& element, const char* name, double otherwise) {
  const auto found = element.child(name);
  return found && !found->text().empty() ? found->text_number() : otherwise;
}

/// Kinds of sensors that SDF has (sdf/1.7/sensor.sdf); its readers refuse others.
const std::set<std::string> kSensors{"air_pressure",
                                     "altimeter",
                                     "camera",
                                     "contact",
                                     "depth",
                                     "depth_camera",
                                     "force_torque",
                                     "gps",
                                     "gpu_lidar",
                                     "gpu_ray",
                                     "imu",
                                     "lidar",
                                     "logical_camera",
                                     "magnetometer",
                                     "multicamera",
                                     "ray",
                                     "rfid",
                                     "rfidtag",
                                     "rgbd",
                                     "rgbd_camera",
                                     "sonar",
                                     "thermal",
                                     "thermal_camera",
                                     "wireless_receiver",
                                     "wireless_transmitter"};

/// Poses that are given in one another.
class Frames {
 public:
  struct Frame {
    std::string relative_to;  // empty: the model's
    RigidTransform X = RigidTransform::Identity();
  };
  void add(const std::string& name, Frame frame) { frames_[name] = std::move(frame); }
  /// Joints may be called as links are: a name is a link's first.
  void add_joint(const std::string& name, Frame frame) { joints_[name] = std::move(frame); }
  RigidTransform joint_in_model(const std::string& name, const std::string& place) const {
    const Frame& frame = joints_.at(name);
    return in_model(frame.relative_to, place) * frame.X;
  }
  /// Of a frame in the model's. @throws geometry::InputError for one that is not there, or a ring
  RigidTransform in_model(const std::string& name, const std::string& place, int depth = 0) const {
    if (name.empty() || name == "__model__") return RigidTransform::Identity();
    auto found = frames_.find(name);
    if (found == frames_.end()) found = joints_.find(name);
    if (found == joints_.end() || depth > 64) {
      throw InputError(
          place + ": frame '" + name + (depth > 64 ? "' is in a ring" : "' is not there"),
          "Name a link, a joint or a frame of the model");
    }
    return in_model(found->second.relative_to, place, depth + 1) * found->second.X;
  }

 private:
  std::map<std::string, Frame> frames_, joints_;
};

/// A <pose>; its frame is `relative_to`, or `otherwise`.
Frames::Frame pose_of(const XmlElement& element, const std::string& otherwise) {
  Frames::Frame frame{otherwise, RigidTransform::Identity()};
  const auto pose = element.child("pose");
  if (!pose) return frame;
  if (auto relative = pose->attribute("relative_to"); relative && !relative->empty()) {
    frame.relative_to = *relative;
  } else if (auto old = pose->attribute("frame"); old && !old->empty()) {
    frame.relative_to = *old;
  }
  if (pose->text().empty()) return frame;
  const auto numbers = pose->text_numbers(6);
  frame.X = from_roll_pitch_yaw({numbers[0], numbers[1], numbers[2]},
                                {numbers[3], numbers[4], numbers[5]});
  return frame;
}

std::optional<Shape> read_sdf_shape(const XmlElement& element) {
  Shape shape;
  shape.name = element.attribute("name").value_or("");
  shape.X_LS = pose_of(element, "").X;
  const auto geometry = element.child("geometry");
  if (!geometry) return std::nullopt;
  if (const auto box = geometry->child("box")) {
    shape.kind = Shape::Kind::kBox;
    const auto size = box->child("size");
    if (!size) box->fail("<box> has no size", "Give it");
    const auto numbers = size->text_numbers(3);
    shape.size = {numbers[0], numbers[1], numbers[2]};
  } else if (const auto sphere = geometry->child("sphere")) {
    shape.kind = Shape::Kind::kSphere;
    shape.radius = number_in(*sphere, "radius", 1);
  } else if (const auto cylinder = geometry->child("cylinder")) {
    shape.kind = Shape::Kind::kCylinder;
    shape.radius = number_in(*cylinder, "radius", 1);
    shape.length = number_in(*cylinder, "length", 1);
  } else if (const auto capsule = geometry->child("capsule")) {
    shape.kind = Shape::Kind::kCapsule;
    shape.radius = number_in(*capsule, "radius", 0.5);
    shape.length = number_in(*capsule, "length", 1);
  } else if (geometry->child("plane")) {
    shape.kind = Shape::Kind::kPlane;
  } else if (const auto mesh = geometry->child("mesh")) {
    shape.kind = Shape::Kind::kMesh;
    const auto uri = mesh->child("uri");
    if (!uri) mesh->fail("<mesh> has no uri", "Name its file");
    shape.mesh = uri->text();
    if (const auto scale = mesh->child("scale")) {
      const auto numbers = scale->text_numbers(3);
      shape.scale = {numbers[0], numbers[1], numbers[2]};
    }
  } else {
    geometry->drop("it is none of box, sphere, cylinder, capsule, plane, mesh");
    return std::nullopt;
  }
  if (const auto material = element.child("material")) {
    const auto diffuse = material->child("diffuse");
    if (diffuse) {
      const auto rgba = diffuse->text_numbers(0);
      if (rgba.size() < 3) diffuse->fail("a colour has three or four numbers", "Mend it");
      shape.color = {{rgba[0], rgba[1], rgba[2], rgba.size() > 3 ? rgba[3] : 1}};
    }
  }
  return shape;
}

LinkDescription read_sdf_link(const XmlElement& element, RobotDescription& robot) {
  LinkDescription link;
  link.name = element.needed("name");
  if (const auto inertial = element.child("inertial")) {
    link.inertial.emplace();
    link.inertial->X_LI = pose_of(*inertial, "").X;
    link.inertial->mass = number_in(*inertial, "mass", 1);
    if (const auto inertia = inertial->child("inertia")) {
      const auto at = [&](const char* name, double other) {
        return number_in(*inertia, name, other);
      };
      const double xy = at("ixy", 0), xz = at("ixz", 0), yz = at("iyz", 0);
      // All are read before: an assertion of Eigen's forbids to throw half way.
      const double xx = at("ixx", 1), yy = at("iyy", 1), zz = at("izz", 1);
      link.inertial->inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    } else {
      link.inertial->inertia = Eigen::Matrix3d::Identity();  // as SDF has it
    }
  }
  for (const XmlElement& one : element.children("visual")) {
    if (auto shape = read_sdf_shape(one)) link.visuals.push_back(std::move(*shape));
  }
  for (const XmlElement& one : element.children("collision")) {
    if (auto shape = read_sdf_shape(one)) link.collisions.push_back(std::move(*shape));
  }
  for (const XmlElement& one : element.children("sensor")) {
    robot.sensors.push_back({one.attribute("name").value_or(""), one.attribute("type").value_or(""),
                             link.name, pose_of(one, "").X, Eigen::Vector3d::Zero()});
  }
  return link;
}

class SdfReader {
 public:
  SdfReader(const XmlElement& model, double version) : model_(model), version_(version) {}

  RobotDescription read() {
    robot_.name = model_.needed("name");
    model_.child("static");
    for (const XmlElement& frame : model_.children("frame")) {
      frames_.add(frame.needed("name"),
                  pose_of(frame, frame.attribute("attached_to").value_or("")));
    }
    if (model_.child("pose")) pose_of(model_, "");  // where the model is in its world
    const auto links = model_.children("link"), joints = model_.children("joint");
    refuse_many_links(std::max(links.size(), joints.size()), model_.place());
    for (const XmlElement& one : links) {
      frames_.add(one.needed("name"), pose_of(one, ""));
      robot_.links.push_back(read_sdf_link(one, robot_));
    }
    for (const XmlElement& one : joints) {
      const auto child = one.child("child");
      if (!child) one.fail("the joint has no child", "Name a link");
      frames_.add_joint(one.needed("name"), pose_of(one, child->text()));
    }
    for (const XmlElement& one : joints) read_joint(one);
    free_links();
    for (const char* nested : {"model", "include"}) {
      for (const XmlElement& one : model_.children(nested)) {
        one.drop("models within models are not read");
      }
    }
    for (const XmlElement& one : model_.children("plugin")) one.drop("plugins are the simulator's");
    return std::move(robot_);
  }

 private:
  /// What no joint holds, beside the first such link, is free.
  void free_links() {
    const std::vector<std::string> beside = roots(robot_);
    for (std::size_t i = 1; i < beside.size(); ++i) {
      JointDescription joint;
      joint.name = beside[i] + "_free";
      joint.kind = Kind::kFloating;
      joint.parent = beside[0];
      joint.child = beside[i];
      joint.X_PJ =
          frames_.in_model(beside[0], "model").inverse() * frames_.in_model(beside[i], "model");
      robot_.joints.push_back(std::move(joint));
    }
  }

  void read_joint(const XmlElement& element) {
    JointDescription joint;
    joint.name = element.needed("name");
    const std::string type = element.needed("type");
    const auto parent = element.child("parent");
    if (!parent) element.fail("the joint has no parent", "Name a link, or world");
    joint.parent = parent->text();
    joint.child = element.child("child")->text();
    const std::map<std::string, Kind> kinds{{"fixed", Kind::kFixed},
                                            {"revolute", Kind::kRevolute},
                                            {"continuous", Kind::kRevolute},
                                            {"prismatic", Kind::kPrismatic},
                                            {"ball", Kind::kBall}};
    const auto kind = kinds.find(type);
    if (kind == kinds.end()) {
      element.approximate("a joint of type '" + type + "' is kept as a fixed one");
    } else {
      joint.kind = kind->second;
    }
    if (joint.parent == "world" && !robot_.link("world")) {
      robot_.links.insert(robot_.links.begin(), {"world", {}, {}, {}});
      frames_.add("world", {});
    }
    for (const std::string& link : {joint.parent, joint.child}) {
      if (!robot_.link(link)) {
        element.fail("link '" + link + "' is not there", "Name a link of the model");
      }
    }
    const RigidTransform X_MJ = frames_.joint_in_model(joint.name, element.place());
    joint.X_PJ = frames_.in_model(joint.parent, element.place()).inverse() * X_MJ;
    joint.X_JC = X_MJ.inverse() * frames_.in_model(joint.child, element.place());
    if (const auto axis = element.child("axis")) read_axis(*axis, X_MJ, type, joint);
    for (const JointDescription& other : robot_.joints) {
      if (other.child != joint.child) continue;
      // A second joint above a link closes a loop.
      element.approximate("'" + joint.child + "' has a joint above it already: kept as a loop");
      robot_.loops.push_back({joint.name,
                              joint.kind == Kind::kFixed ? Loop::Kind::kWeld : Loop::Kind::kPoint,
                              joint.parent, joint.child, joint.X_PJ});
      return;
    }
    robot_.joints.push_back(std::move(joint));
  }

  void read_axis(const XmlElement& axis, const RigidTransform& X_MJ, const std::string& type,
                 JointDescription& joint) {
    const auto xyz = axis.child("xyz");
    Eigen::Vector3d direction(0, 0, 1);
    std::string expressed_in;
    if (xyz) {
      const auto numbers = xyz->text_numbers(3);
      direction = {numbers[0], numbers[1], numbers[2]};
      expressed_in = xyz->attribute("expressed_in").value_or("");
    }
    const auto old = axis.child("use_parent_model_frame");
    const bool in_model = old ? old->text() == "1" || old->text() == "true" : version_ < 1.5;
    if (!(direction.norm() > 1e-9)) axis.fail("the axis has no length", "Give a direction");
    if (!expressed_in.empty()) {
      direction = X_MJ.linear().transpose() *
                  frames_.in_model(expressed_in, axis.place()).linear() * direction;
    } else if (in_model) {
      direction = X_MJ.linear().transpose() * direction;
    }
    joint.axis_J = direction.normalized();
    if (const auto limit = axis.child("limit")) {
      const double lower = number_in(*limit, "lower", -kUnlimited);
      const double upper = number_in(*limit, "upper", kUnlimited);
      if (type != "continuous" && lower > -kUnlimited) joint.lower = lower;
      if (type != "continuous" && upper < kUnlimited) joint.upper = upper;
      const double effort = number_in(*limit, "effort", -1);
      const double velocity = number_in(*limit, "velocity", -1);
      if (effort >= 0) joint.effort = effort;
      if (velocity >= 0) joint.velocity = velocity;
    }
    if (const auto dynamics = axis.child("dynamics")) {
      joint.damping = number_in(*dynamics, "damping", 0);
      joint.friction = number_in(*dynamics, "friction", 0);
      const double stiffness = number_in(*dynamics, "spring_stiffness", 0);
      joint.rest = number_in(*dynamics, "spring_reference", 0);
      if (stiffness != 0) joint.stiffness = stiffness;
    }
    if (const auto mimic = axis.child("mimic")) {
      const double multiplier = number_in(*mimic, "multiplier", 1);
      joint.follows =
          Follows{mimic->needed("joint"), multiplier,
                  number_in(*mimic, "offset", 0) - multiplier * number_in(*mimic, "reference", 0)};
    }
  }

  const XmlElement model_;
  const double version_;
  RobotDescription robot_;
  Frames frames_;
};

class SdfWriter {
 public:
  SdfWriter(const RobotDescription& robot, LossReport& loss) : robot_(robot), loss_(loss) {}

  std::string write() {
    line(0, "<?xml version=\"1.0\"?>");
    line(0, fmt::format("<sdf version=\"{}\">", kWritten));
    line(1, fmt::format("<model name=\"{}\">", escaped(robot_.name)));
    // Where each joint is at 0, also those that follow another by an offset.
    RobotDescription at_zero = robot_;
    for (JointDescription& joint : at_zero.joints) joint.follows.reset();
    const auto poses = link_poses(at_zero, {});
    for (const LinkDescription& link : robot_.links) {
      if (link.name == "world" && link.collisions.empty() && link.visuals.empty()) continue;
      write_link(link, poses.at(link.name));
    }
    for (const JointDescription& joint : robot_.joints) write_joint(joint);
    line(1, "</model>");
    line(0, "</sdf>");
    for (const Loop& loop : robot_.loops) {
      loss_.drop("loop '" + loop.name + "'", "loop", "it is not written yet");
    }
    for (const Actuator& actuator : robot_.actuators) {
      loss_.drop("actuator '" + actuator.name + "'", "actuator", "SDF has none but by plugins");
    }
    for (const Posture& one : robot_.postures) {
      loss_.drop("posture '" + one.name + "'", "posture", "SDF has no postures");
    }
    for (const JointDescription& joint : robot_.joints) {
      if (joint.passive) loss_.drop("joint '" + joint.name + "'", "passive joint", "SDF has none");
    }
    for (const Manipulator& one : robot_.manipulators) {
      loss_.drop("manipulator '" + one.name + "'", "manipulator", "SDF has no manipulators");
    }
    if (!robot_.disabled_collisions.empty()) {
      loss_.drop("robot",
                 fmt::format("{} pairs of links that may touch", robot_.disabled_collisions.size()),
                 "SDF has no such pairs");
    }
    return std::move(text_);
  }

 private:
  void line(int depth, const std::string& words) {
    text_.append(2 * static_cast<std::size_t>(depth), ' ').append(words).push_back('\n');
  }
  void pose(int depth, const RigidTransform& X, const std::string& relative = "") {
    if (relative.empty() && X.isApprox(RigidTransform::Identity(), 0)) return;
    line(depth, fmt::format("<pose{}>{}</pose>",
                            relative.empty() ? "" : " relative_to=\"" + escaped(relative) + "\"",
                            pose_text(X)));
  }
  void number(int depth, const char* name, double value) {
    line(depth, fmt::format("<{0}>{1}</{0}>", name, number_text(value)));
  }
  void write_link(const LinkDescription& link, const RigidTransform& X) {
    loss_.keep("link");
    line(2, fmt::format("<link name=\"{}\">", escaped(link.name)));
    pose(3, X);
    if (link.inertial) {
      line(3, "<inertial>");
      pose(4, link.inertial->X_LI);
      number(4, "mass", link.inertial->mass);
      line(4, "<inertia>");
      const Eigen::Matrix3d& I = link.inertial->inertia;
      number(5, "ixx", I(0, 0));
      number(5, "ixy", I(0, 1));
      number(5, "ixz", I(0, 2));
      number(5, "iyy", I(1, 1));
      number(5, "iyz", I(1, 2));
      number(5, "izz", I(2, 2));
      line(4, "</inertia>");
      line(3, "</inertial>");
    }
    int count = 0;
    for (const Shape& shape : link.visuals) write_shape(shape, "visual", count++);
    count = 0;
    for (const Shape& shape : link.collisions) write_shape(shape, "collision", count++);
    for (const Sensor& sensor : robot_.sensors) {
      if (sensor.link != link.name) continue;
      if (kSensors.count(sensor.kind) == 0) {
        loss_.drop("sensor '" + sensor.name + "'", sensor.kind, "SDF has none of that kind");
        continue;
      }
      loss_.keep("sensor");
      line(3, fmt::format("<sensor name=\"{}\" type=\"{}\">", escaped(sensor.name),
                          escaped(sensor.kind)));
      pose(4, sensor.X_LS);
      line(3, "</sensor>");
    }
    line(2, "</link>");
  }
  void write_shape(const Shape& shape, const char* element, int count) {
    loss_.keep(element);
    const std::string name = shape.name.empty() ? fmt::format("{}_{}", element, count) : shape.name;
    line(3, fmt::format("<{} name=\"{}\">", element, escaped(name)));
    pose(4, shape.X_LS);
    line(4, "<geometry>");
    switch (shape.kind) {
      case Shape::Kind::kBox:
        line(5, fmt::format("<box><size>{}</size></box>", numbers_text(shape.size)));
        break;
      case Shape::Kind::kSphere:
        line(5, fmt::format("<sphere><radius>{}</radius></sphere>", number_text(shape.radius)));
        break;
      case Shape::Kind::kCylinder:
      case Shape::Kind::kCapsule:
        line(5, fmt::format("<{0}><radius>{1}</radius><length>{2}</length></{0}>",
                            shape.kind == Shape::Kind::kCylinder ? "cylinder" : "capsule",
                            number_text(shape.radius), number_text(shape.length)));
        break;
      case Shape::Kind::kPlane:
        line(5, "<plane><normal>0 0 1</normal></plane>");
        break;
      case Shape::Kind::kMesh:
        line(5, fmt::format("<mesh><uri>{}</uri><scale>{}</scale></mesh>", escaped(shape.mesh),
                            numbers_text(shape.scale)));
        break;
    }
    line(4, "</geometry>");
    if (std::string(element) == "visual" && shape.color) {
      const auto& c = *shape.color;
      line(4, fmt::format("<material><diffuse>{} {} {} {}</diffuse></material>", number_text(c[0]),
                          number_text(c[1]), number_text(c[2]), number_text(c[3])));
    }
    line(3, fmt::format("</{}>", element));
  }
  void write_joint(const JointDescription& joint) {
    loss_.keep("joint");
    const std::string place = "joint '" + joint.name + "'";
    if (joint.kind == Kind::kFloating) return;  // as a link that no joint holds
    if (joint.kind == Kind::kPlanar) {
      return loss_.approximate(place, "planar joint", "its link is free: SDF has no planar joints");
    }
    const bool moves = joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
    const char* type = joint.kind == Kind::kFixed       ? "fixed"
                       : joint.kind == Kind::kPrismatic ? "prismatic"
                       : joint.kind == Kind::kBall      ? "ball"
                                                        : "revolute";
    line(2, fmt::format("<joint name=\"{}\" type=\"{}\">", escaped(joint.name), type));
    pose(3, joint.X_JC.inverse());
    line(3, fmt::format("<parent>{}</parent>", escaped(joint.parent)));
    line(3, fmt::format("<child>{}</child>", escaped(joint.child)));
    if (moves) {
      line(3, "<axis>");
      line(4, fmt::format("<xyz>{}</xyz>", numbers_text(joint.axis_J)));
      line(4, "<limit>");
      number(5, "lower", joint.lower.value_or(-kUnlimited));
      number(5, "upper", joint.upper.value_or(kUnlimited));
      if (joint.effort) number(5, "effort", *joint.effort);
      if (joint.velocity) number(5, "velocity", *joint.velocity);
      line(4, "</limit>");
      line(4, "<dynamics>");
      number(5, "damping", joint.damping);
      number(5, "friction", joint.friction);
      if (joint.stiffness) {
        number(5, "spring_stiffness", *joint.stiffness);
        number(5, "spring_reference", joint.rest);
      }
      line(4, "</dynamics>");
      if (joint.follows) {
        const CouplingLine coupling = coupling_line(robot_, joint);
        line(4, fmt::format("<mimic joint=\"{}\"><multiplier>{}</multiplier><offset>{}</offset>"
                            "<reference>0</reference></mimic>",
                            escaped(coupling.line.joint), number_text(coupling.line.multiplier()),
                            number_text(coupling.line.offset())));
        if (!joint.follows->is_linear()) {
          loss_.approximate(place, "polynomial coupling", words_of_line(coupling, joint));
        }
        loss_.approximate(place, "mimic", "as SDF 1.11 has it; older readers pass over it");
      }
      line(3, "</axis>");
    }
    if (joint.break_away) {
      loss_.approximate(place, "break-away clutch", "a mimic that never stays behind");
    }
    line(2, "</joint>");
  }

  const RobotDescription& robot_;
  LossReport& loss_;
  std::string text_;
};

class Sdf : public RobotFormat {
 public:
  std::string name() const override { return "sdf"; }
  bool recognises(const XmlElement& root) const override {
    return root.name() == "sdf" || root.name() == "gazebo";  // until version 1.2
  }
  std::string ending() const override { return ".sdf"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    TrackedXml document = TrackedXml::read(file, loss);
    const XmlElement root = document.root();
    const double version = root.needed_number("version");
    std::optional<XmlElement> model = root.child("model");
    if (!model) {
      if (const auto world = root.child("world")) {
        world->attribute("name");
        model = world->child("model");
      }
    }
    if (!model) root.fail("there is no model in it", "Name a file that has one");
    RobotDescription robot = SdfReader(*model, version).read();
    const auto blocks = model->children(kBlock);
    document.finish();
    tree_order(robot);
    apply_extension(blocks, robot, loss);
    return robot;
  }
  bool can_write() const override { return true; }
  std::string write(const RobotDescription& robot, LossReport& loss) const override {
    LossReport written;
    std::string text = SdfWriter(robot, written).write();
    const auto again = [&] {
      LossReport unused;
      TrackedXml document(text, "robot.sdf", unused);
      RobotDescription plain = SdfReader(*document.root().child("model"), kWritten).read();
      tree_order(plain);
      return plain;
    };
    const std::string block = extension_text(robot, again, written, loss);
    if (!block.empty()) {
      text.insert(text.rfind("  </model>"),
                  fmt::format("    <{0} xmlns:prehend=\"{1}\">{2}</{0}>\n", kBlock, kNamespace,
                              escaped_text(block)));
    }
    return text;
  }

 private:
  // Elements of other namespaces are others' (sdformat.org/tutorials, "custom elements").
  static constexpr const char* kBlock = "prehend:robot";
  static constexpr const char* kNamespace = "urn:prehend:robot";
};

}  // namespace

std::unique_ptr<RobotFormat> sdf_format() { return std::make_unique<Sdf>(); }

}  // namespace prehend::robot::formats
