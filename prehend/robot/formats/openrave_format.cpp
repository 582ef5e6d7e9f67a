// OpenRAVE's own XML (its reader of 2009 to 2024), the format before COLLADA: bodies that stand in
// their robot's frame, joints with an anchor, names in any case.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/tracked_xml.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using Kind = JointDescription::Kind;

constexpr double kTurn = std::numbers::pi / 180;  // rad of a degree

bool is_called(const std::string& name, const char* word) {
  return std::equal(name.begin(), name.end(), word, word + std::char_traits<char>::length(word),
                    [](char a, char b) { return std::tolower(a) == std::tolower(b); });
}

/// Translations add up; a later rotation comes before an earlier one, about fixed axes.
RigidTransform placed(const XmlElement& element) {
  RigidTransform X = RigidTransform::Identity();
  for (const XmlElement& one : element.children("translation")) {
    const auto n = one.text_numbers(3);
    X.translation() += Eigen::Vector3d(n[0], n[1], n[2]);
  }
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  for (const XmlElement& one : element.children()) {
    const std::string name = one.name();
    if (is_called(name, "rotationaxis")) {
      const auto n = one.text_numbers(4);
      const Eigen::Vector3d axis(n[0], n[1], n[2]);
      if (!(axis.norm() > 1e-9)) one.fail("the axis has no length", "Give a direction");
      turn = Eigen::AngleAxisd(kTurn * n[3], axis.normalized()) * turn;
    } else if (is_called(name, "rotationmat")) {
      const auto n = one.text_numbers(9);
      const Eigen::Matrix3d given =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(n.data());
      turn = Eigen::Quaterniond(given).normalized() * turn;
    } else if (is_called(name, "quat")) {
      const auto n = one.text_numbers(4);
      turn = Eigen::Quaterniond(n[0], n[1], n[2], n[3]).normalized() * turn;
    }
  }
  X.linear() = turn.toRotationMatrix();
  return X;
}

/// "JF1/3+0.8727", "-J2*0.5", "J1 0.333 0": name, factor, offset.
std::optional<Follows> follows_of(const std::string& formula) {
  static const std::regex kForm(
      R"(\s*([-+]?)\s*([A-Za-z_]\w*)\s*(?:([*/])\s*([0-9.eE]+))?\s*(?:([-+])\s*([0-9.eE]+))?\s*)");
  static const std::regex kOther(
      R"(\s*([-+]?[0-9.eE]+)\s*\*\s*([A-Za-z_]\w*)\s*(?:([-+])\s*([0-9.eE]+))?\s*)");
  std::smatch match;
  const auto number = [](const std::string& text) { return parse_numbers(text, 1, text).front(); };
  // The library's regular expressions call themselves for each sign.
  constexpr std::size_t kLongest = 400;
  if (formula.size() > kLongest) return std::nullopt;
  if (std::regex_match(formula, match, kForm)) {
    double multiplier = match[1] == "-" ? -1.0 : 1.0, offset = 0;
    if (match[3] == "*") multiplier *= number(match[4]);
    if (match[3] == "/") multiplier /= number(match[4]);
    if (match[5].matched) offset = (match[5] == "-" ? -1 : 1) * number(match[6]);
    return Follows{match[2], multiplier, offset};
  }
  if (std::regex_match(formula, match, kOther)) {
    const double offset = match[3].matched ? (match[3] == "-" ? -1 : 1) * number(match[4]) : 0.0;
    return Follows{match[2], number(match[1]), offset};
  }
  return std::nullopt;
}

class OpenRaveReader {
 public:
  explicit OpenRaveReader(LossReport& loss) : loss_(loss) {}

  void read_file(const std::filesystem::path& file, const std::string& prefix, int depth) {
    files_.spend(file);
    TrackedXml document = TrackedXml::read(file, loss_);
    document.ignore_case();
    const XmlElement root = document.root();
    if (depth > 16) root.fail("files are in a ring", "Leave one file attribute away");
    read_body_or_robot(root, file, prefix, depth);
    document.finish();
  }

  RobotDescription finish() {
    const std::vector<std::string> beside = roots(robot_);
    for (std::size_t i = 1; i < beside.size(); ++i) {
      JointDescription weld;
      weld.name = beside[i] + "_weld";
      weld.parent = beside[0];
      weld.child = beside[i];
      weld.X_PJ = poses_.at(beside[0]).inverse() * poses_.at(beside[i]);
      loss_.approximate("body '" + beside[i] + "'", "body without a joint",
                        "fixed to '" + beside[0] + "'");
      robot_.joints.push_back(std::move(weld));
    }
    return std::move(robot_);
  }

 private:
  void read_body_or_robot(const XmlElement& element, const std::filesystem::path& file,
                          const std::string& above, int depth) {
    // Of what the file brings; what stands here has its whole name.
    const std::string of_file = above + element.attribute("prefix").value_or("");
    const std::string& prefix = above;
    if (robot_.name.empty()) {
      robot_.name = element.attribute("name").value_or(file.stem().stem().string());
    }
    element.attribute("name");
    if (const auto other = element.attribute("file")) {
      const std::filesystem::path path = file.parent_path() / *other;
      std::error_code error;
      if (!std::filesystem::is_regular_file(path, error)) {
        loss_.drop(element.place(), "file '" + *other + "'", "it is not there");
      } else if (path.extension() == ".zae" || path.extension() == ".dae") {
        loss_.drop(element.place(), "file '" + *other + "'", "COLLADA is not read");
      } else {
        read_file(path, of_file, depth + 1);
      }
    }
    for (const XmlElement& one : element.children()) {
      const std::string name = one.name();
      if (is_called(name, "KinBody") || is_called(name, "Robot")) {
        read_body_or_robot(one, file, prefix, depth);
      } else if (is_called(name, "Body")) {
        read_body(one, prefix);
      } else if (is_called(name, "Joint")) {
        read_joint(one, prefix);
      } else if (is_called(name, "Manipulator")) {
        read_manipulator(one, prefix);
      } else if (is_called(name, "AttachedSensor")) {
        read_sensor(one, prefix);
      } else if (is_called(name, "adjacent")) {
        std::istringstream words(one.text());
        std::string first, second;
        if (words >> first >> second) {
          robot_.disabled_collisions.emplace_back(prefix + first, prefix + second);
        }
      } else if (is_called(name, "jointvalues")) {
        one.drop("where it stands at first");
      } else if (is_called(name, "translation") || is_called(name, "rotationaxis") ||
                 is_called(name, "rotationmat") || is_called(name, "quat")) {
        one.drop("where the robot stands in its scene");
      } else if (is_called(name, "modelsdir")) {
        folder_ = one.text() + "/";
      } else {
        one.drop("nothing here is made of it");
      }
    }
  }

  RigidTransform frame_of(const XmlElement& element, const std::string& prefix) const {
    const auto from = element.child("offsetfrom");
    if (!from) return RigidTransform::Identity();
    const auto found = poses_.find(prefix + from->text());
    if (found == poses_.end()) {
      from->fail("body '" + from->text() + "' is not there, or stands later in the file",
                 "Name one that was said before");
    }
    return found->second;
  }

  void read_body(const XmlElement& element, const std::string& prefix) {
    const std::string name = prefix + element.needed("name");
    element.attribute("type");
    element.attribute("enable");
    auto known = std::find_if(robot_.links.begin(), robot_.links.end(),
                              [&](const auto& one) { return one.name == name; });
    if (known == robot_.links.end()) {
      refuse_many_links(robot_.links.size() + 1, element.place());
      robot_.links.push_back({name, {}, {}, {}});
      known = robot_.links.end() - 1;
      poses_[name] = RigidTransform::Identity();
    }
    if (element.child("offsetfrom") || element.child("translation") ||
        element.child("rotationaxis") || element.child("rotationmat") || element.child("quat")) {
      poses_[name] = frame_of(element, prefix) * placed(element);
    }
    for (const XmlElement& one : element.children("Geom")) read_geom(one, *known);
    if (const auto mass = element.child("mass")) read_mass(*mass, *known);
  }

  void read_geom(const XmlElement& element, LinkDescription& link) {
    const std::string type = element.attribute("type").value_or("none");
    Shape shape;
    shape.X_LS = placed(element);
    if (const auto color = element.child("diffuseColor")) {
      const auto n = color->text_numbers(0);
      if (n.size() >= 3) shape.color = {{n[0], n[1], n[2], 1}};
    }
    for (const char* look : {"ambientColor", "transparency"}) {
      if (const auto one = element.child(look)) one->drop("how it is lit");
    }
    const auto number = [&](const char* name) {
      const auto one = element.child(name);
      if (!one) element.fail(std::string("<Geom> has no ") + name, "Give it");
      return one->text_number();
    };
    if (is_called(type, "box")) {
      const auto half = element.child("extents"), full = element.child("fullextents");
      if (!half && !full) element.fail("the box has no extents", "Give half of its sides");
      const auto n = (half ? half : full)->text_numbers(3);
      shape.size = (half ? 2 : 1) * Eigen::Vector3d(n[0], n[1], n[2]);
    } else if (is_called(type, "sphere")) {
      shape.kind = Shape::Kind::kSphere;
      shape.radius = number("radius");
    } else if (is_called(type, "cylinder") || is_called(type, "capsule")) {
      shape.kind = is_called(type, "cylinder") ? Shape::Kind::kCylinder : Shape::Kind::kCapsule;
      shape.radius = number("radius");
      shape.length = number("height");
      // It stands along y here.
      shape.X_LS.rotate(Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
    } else if (is_called(type, "trimesh")) {
      return read_meshes(element, shape, link);
    } else {
      return element.drop("a geometry of type '" + type + "' is not kept");
    }
    link.collisions.push_back(shape);
    if (element.attribute("render").value_or("true") != "false") link.visuals.push_back(shape);
  }

  void read_meshes(const XmlElement& element, Shape shape, LinkDescription& link) const {
    shape.kind = Shape::Kind::kMesh;
    const auto read = [&](const char* name, std::vector<Shape>& to) {
      for (const XmlElement& one : element.children(name)) {
        std::istringstream words(one.text());
        std::string file;
        double scale = 1;
        words >> file;
        if (!(words >> scale)) scale = 1;
        shape.mesh = folder_ + file;
        shape.scale = Eigen::Vector3d::Constant(scale);
        to.push_back(shape);
      }
    };
    read("data", link.collisions);
    read("collision", link.collisions);
    read("render", link.visuals);
  }

  static void read_mass(const XmlElement& element, LinkDescription& link) {
    const std::string type = element.attribute("type").value_or("");
    Inertial inertial;
    if (const auto total = element.child("total")) inertial.mass = total->text_number();
    if (const auto center = element.child("com")) {
      const auto n = center->text_numbers(3);
      inertial.X_LI.translation() = Eigen::Vector3d(n[0], n[1], n[2]);
    }
    if (is_called(type, "custom")) {
      if (const auto matrix = element.child("inertia")) {
        const auto n = matrix->text_numbers(9);
        const Eigen::Matrix3d given = Eigen::Map<const Eigen::Matrix3d>(n.data());
        inertial.inertia = 0.5 * (given + given.transpose());
      }
    } else if (is_called(type, "box") && element.child("extents")) {
      const auto n = element.child("extents")->text_numbers(3);
      inertial.inertia = inertial.mass / 3 *
                         Eigen::Vector3d(n[1] * n[1] + n[2] * n[2], n[0] * n[0] + n[2] * n[2],
                                         n[0] * n[0] + n[1] * n[1])
                             .asDiagonal();
    } else if (is_called(type, "sphere") && element.child("radius")) {
      const double r = element.child("radius")->text_number();
      inertial.inertia = 0.4 * inertial.mass * r * r * Eigen::Matrix3d::Identity();
    } else {
      return element.drop("a mass that is as the geometry's is not computed");
    }
    if (inertial.mass > 0) link.inertial = inertial;
  }

  void read_joint(const XmlElement& element, const std::string& prefix) {
    JointDescription joint;
    joint.name = prefix + element.needed("name");
    refuse_many_links(robot_.joints.size() + 1, element.place());
    const std::string type = element.attribute("type").value_or("hinge");
    const auto bodies = element.children("Body");
    if (bodies.size() != 2) element.fail("the joint has not two bodies", "Name parent and child");
    joint.parent = prefix + bodies[0].text();
    joint.child = prefix + bodies[1].text();
    for (const std::string& link : {joint.parent, joint.child}) {
      if (poses_.count(link) == 0) {
        element.fail("body '" + link + "' is not there", "Name one that was said before");
      }
    }
    if (is_called(type, "hinge")) {
      joint.kind = Kind::kRevolute;
    } else if (is_called(type, "slider")) {
      joint.kind = Kind::kPrismatic;
    } else if (is_called(type, "spherical")) {
      joint.kind = Kind::kBall;
    } else {
      element.approximate("a joint of type '" + type + "' is kept as a fixed one");
    }
    const bool turns = joint.kind == Kind::kRevolute;
    const RigidTransform X_RF = frame_of(element, prefix);
    Eigen::Vector3d axis(0, 0, 1), anchor(0, 0, 0);
    if (const auto one = element.child("axis")) {
      const auto n = one->text_numbers(3);
      axis = {n[0], n[1], n[2]};
      if (!(axis.norm() > 1e-9)) one->fail("the axis has no length", "Give a direction");
    }
    if (const auto one = element.child("anchor")) {
      const auto n = one->text_numbers(3);
      anchor = {n[0], n[1], n[2]};
    }
    const double unit = turns ? kTurn : 1;
    const auto low = element.child("lostop"), high = element.child("histop");
    if (low || high) {
      // The same numbers as limitsdeg turn the other way.
      axis = -axis;
      if (low) joint.lower = unit * low->text_number();
      if (high) joint.upper = unit * high->text_number();
    }
    const auto limits = [&](const char* name, double in) {
      const auto one = element.child(name);
      if (!one) return;
      const auto n = one->text_numbers(2);
      joint.lower = in * std::min(n[0], n[1]);
      joint.upper = in * std::max(n[0], n[1]);
    };
    limits("limits", 1);
    limits("limitsrad", 1);
    limits("limitsdeg", unit);
    if (const auto one = element.child("maxvel")) joint.velocity = one->text_number();
    if (const auto one = element.child("maxveldeg")) joint.velocity = unit * one->text_number();
    if (const auto one = element.child("maxtorque")) joint.effort = one->text_number();
    for (const char* other :
         {"maxaccel", "maxacceldeg", "weight", "resolution", "initial", "circular", "maxinertia"}) {
      if (const auto one = element.child(other)) one->drop("it is of OpenRAVE's own planners");
    }
    read_mimic(element, prefix, joint);
    const bool is_passive = element.attribute("enable").value_or("true") == "false";
    joint.passive = is_passive;
    if (is_passive && joint.lower && joint.upper && *joint.lower == 0 && *joint.upper == 0) {
      joint.kind = Kind::kFixed;
      joint.passive = false;
      joint.lower.reset();
      joint.upper.reset();
    }
    RigidTransform X_RJ = poses_.at(joint.child);
    X_RJ.translation() = X_RF * anchor;
    joint.axis_J = X_RJ.linear().transpose() * X_RF.linear() * axis.normalized();
    joint.X_PJ = poses_.at(joint.parent).inverse() * X_RJ;
    joint.X_JC = X_RJ.inverse() * poses_.at(joint.child);
    robot_.joints.push_back(std::move(joint));
  }

  static void read_mimic(const XmlElement& element, const std::string& prefix,
                         JointDescription& joint) {
    element.attribute("mimic_vel");
    element.attribute("mimic_accel");
    std::optional<Follows> follows;
    if (const auto formula = element.attribute("mimic_pos")) {
      follows = follows_of(*formula);
      if (!follows) element.drop_attribute("mimic_pos", "it is no linear formula of one joint");
    } else if (const auto old = element.attribute("mimic")) {
      std::istringstream words(*old);
      std::string leader;
      double multiplier = 1, offset = 0;
      if (words >> leader >> multiplier >> offset) follows = Follows{leader, multiplier, offset};
    }
    if (!follows) return;
    follows->joint = prefix + follows->joint;
    joint.follows = follows;
  }

  void read_manipulator(const XmlElement& element, const std::string& prefix) {
    Manipulator manipulator;
    manipulator.name = prefix + element.attribute("name").value_or("");
    const auto base = element.child("base"), tip = element.child("effector");
    if (base) manipulator.base = prefix + base->text();
    if (tip) manipulator.tip = prefix + tip->text();
    if (poses_.count(manipulator.base) == 0 || poses_.count(manipulator.tip) == 0) {
      return element.drop("its links are not there");
    }
    manipulator.X_TipTool = placed(element);
    std::vector<std::string> names;
    for (const char* list : {"joints", "gripperjoints"}) {
      const auto one = element.child(list);
      if (!one) continue;
      std::istringstream words(one->text());
      for (std::string word; words >> word;) names.push_back(prefix + word);
    }
    std::vector<double> ways;
    for (const char* list : {"closingdirection", "chuckingdirection"}) {
      if (const auto one = element.child(list)) ways = one->text_numbers(0);
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      manipulator.closing.emplace_back(names[i], i < ways.size() ? ways[i] : 0);
    }
    for (const char* other : {"armjoints", "direction", "palmdirection", "iksolver"}) {
      if (const auto one = element.child(other)) {
        one->drop("of a manipulator, links, tool and closing directions are kept");
      }
    }
    robot_.manipulators.push_back(std::move(manipulator));
  }

  void read_sensor(const XmlElement& element, const std::string& prefix) {
    Sensor sensor;
    sensor.name = element.attribute("name").value_or("");
    if (const auto link = element.child("link")) sensor.link = prefix + link->text();
    sensor.X_LS = placed(element);
    if (const auto one = element.child("sensor")) sensor.kind = one->attribute("type").value_or("");
    robot_.sensors.push_back(std::move(sensor));
  }

  LossReport& loss_;
  FileBudget files_;
  RobotDescription robot_;
  std::map<std::string, RigidTransform> poses_;  // of bodies, in the robot's frame, at zero
  std::string folder_;                           // of meshes
};

class OpenRave : public RobotFormat {
 public:
  std::string name() const override { return "openrave"; }
  std::string ending() const override { return ".xml"; }
  bool recognises(const XmlElement& root) const override {
    if (is_called(root.name(), "KinBody")) return true;
    if (!is_called(root.name(), "Robot")) return false;
    for (const XmlElement& one : root.children()) {
      for (const char* own : {"KinBody", "Body", "Manipulator", "AttachedSensor", "Robot"}) {
        if (is_called(one.name(), own)) return true;
      }
    }
    return root.attribute("file").has_value();
  }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    OpenRaveReader reader(loss);
    reader.read_file(file, "", 0);
    RobotDescription robot = reader.finish();
    tree_order(robot);
    return robot;
  }
};

}  // namespace

std::unique_ptr<RobotFormat> openrave_format() { return std::make_unique<OpenRave>(); }

}  // namespace prehend::robot::formats
