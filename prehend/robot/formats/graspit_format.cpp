// GraspIt!'s robots (its manual, "data files"; graspit-simulator, robot.cpp, kinematicChain.cpp,
// joint.cpp): chains from a palm by Denavit and Hartenberg's parameters, in millimetres and
// degrees, joints that follow motors.

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
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

using geometry::InputError;
using geometry::RigidTransform;
using Kind = JointDescription::Kind;

constexpr double kMillimetre = 1e-3;                  // m
constexpr double kGram = 1e-3;                        // kg
constexpr double kDegree = std::numbers::pi / 180.0;  // rad
constexpr double kEffortUnit = 1e6;                   // of maxEffort: N mm, N
constexpr double kDefaultMass = 0.3;                  // kg, GraspIt!'s own

RigidTransform turned(double angle, const Eigen::Vector3d& axis) {
  return RigidTransform(Eigen::AngleAxisd(angle, axis));
}
RigidTransform moved(const Eigen::Vector3d& by) {
  RigidTransform X = RigidTransform::Identity();
  X.translation() = by;
  return X;
}

RigidTransform transform_of(const XmlElement& element) {
  RigidTransform X = RigidTransform::Identity();
  for (const XmlElement& step : element.children()) {
    if (step.name() == "translation") {
      const auto n = step.text_numbers(3);
      X = X * moved(kMillimetre * Eigen::Vector3d(n[0], n[1], n[2]));
    } else if (step.name() == "rotation") {
      std::istringstream words(step.text());
      double angle = 0;
      std::string axis;
      if (!(words >> angle >> axis) || axis.size() != 1 || axis < "x" || axis > "z") {
        step.fail("'" + step.text() + "' is no angle and axis", "Write degrees and x, y or z");
      }
      X = X * turned(angle * kDegree, Eigen::Vector3d::Unit(axis[0] - 'x'));
    } else if (step.name() == "rotationMatrix") {
      const auto n = step.text_numbers(9);
      const Eigen::Matrix3d given = Eigen::Map<const Eigen::Matrix3d>(n.data());  // by columns
      const Eigen::Quaterniond nearest(given);
      const double off = (given - nearest.normalized().toRotationMatrix()).cwiseAbs().maxCoeff();
      if (off > 1e-3) step.approximate(fmt::format("made orthonormal: it was off by {:.2g}", off));
      X.rotate(nearest.normalized());
    } else if (step.name() == "fullTransform") {
      std::string text = step.text();
      for (char& c : text) {
        if (c == '(' || c == ')' || c == '[' || c == ']' || c == '+') c = ' ';
      }
      const auto n = parse_numbers(text, 7, step.place());
      X = X * geometry::make_transform(Eigen::Quaterniond(n[0], n[1], n[2], n[3]),
                                       kMillimetre * Eigen::Vector3d(n[4], n[5], n[6]));
    } else {
      step.drop("no step of a transform");
    }
  }
  return X;
}

/// "d3*0.5+-20": motor, factor, offset.
struct Variable {
  int motor = 0;
  double factor = 1, offset = 0;
};

std::optional<Variable> variable_of(const XmlElement& element) {
  static const std::regex kForm(
      R"(d(\d+)(?:\*([-+]?[0-9.eE]+))?(?:\+([-+]?[0-9.eE]+)|(-[0-9.eE]+))?)");
  std::string text = element.text();
  std::smatch match;
  // The library's regular expressions call themselves for each sign.
  constexpr std::size_t kLongest = 100;
  if (text.size() > kLongest || !std::regex_match(text, match, kForm)) return std::nullopt;
  constexpr std::ptrdiff_t kMostDigits = 6;
  if (match[1].length() > kMostDigits) return std::nullopt;
  Variable variable;
  variable.motor = std::stoi(match[1]);
  if (match[2].matched) {
    variable.factor = parse_numbers(match[2], 1, element.place()).front();
  }
  if (match[3].matched) variable.offset = parse_numbers(match[3], 1, element.place()).front();
  if (match[4].matched) {
    variable.offset = parse_numbers(match[4], 1, element.place()).front();
    element.approximate("the offset of '" + text +
                        "' is taken as it is meant; GraspIt! itself reads 0 after a '-'");
  }
  return variable;
}

struct Motor {
  char type = 'r';
  double effort = 0, break_away = 0;
};

class GraspItReader {
 public:
  GraspItReader(const XmlElement& root, std::filesystem::path file, LossReport& loss)
      : root_(root), file_(std::move(file)), loss_(loss) {}

  RobotDescription read() {
    root_.attribute("type");
    robot_.name = file_.stem().string();
    const auto palm = root_.child("palm");
    if (!palm) root_.fail("the robot has no palm", "Name its body");
    robot_.links.push_back(read_body("palm", palm->text(), palm->place()));
    for (const XmlElement& one : root_.children("dof")) read_motor(one);
    const auto chains = root_.children("chain");
    for (std::size_t i = 0; i < chains.size(); ++i) read_chain(chains[i], i);
    for (const XmlElement& one : root_.children("filter")) read_cell(one, "palm");
    if (const auto way = root_.child("approachDirection")) {
      way->child("referenceLocation");
      way->child("direction");
    }
    for (const char* file : {"eigenGrasps", "virtualContacts", "cyberGlove"}) {
      for (const XmlElement& one : root_.children(file)) one.drop("files of postures are not kept");
    }
    for (const XmlElement& one : root_.children("flockOfBirds")) {
      one.drop("where a magnetic tracker is mounted");
    }
    for (const XmlElement& one : root_.children("disableCollision")) read_pair(one);
    name_motors();
    return std::move(robot_);
  }

 private:
  void read_motor(const XmlElement& element) {
    Motor motor;
    refuse_many_links(motors_.size() + 1, element.place());
    motor.type = element.attribute("type").value_or("r").substr(0, 1)[0];
    const auto number = [&](const char* name) {
      const auto one = element.child(name);
      return one ? one->text_number() : 0.0;
    };
    motor.effort = number("maxEffort");
    motor.break_away = number("breakAwayTorque");
    if (const auto one = element.child("defaultValue")) one->drop("where it stands at first");
    if (const auto one = element.child("defaultVelocity")) one->drop("which way it closes");
    for (const char* arbitrary : {"Kp", "Kd", "draggerScale"}) {
      if (const auto one = element.child(arbitrary)) {
        one->drop("it is of GraspIt!'s own controller");
      }
    }
    motors_.push_back(motor);
  }

  /// A link of a body's file, in the folder iv beside the robot's.
  LinkDescription read_body(const std::string& name, const std::string& file,
                            const std::string& place) {
    LinkDescription link;
    link.name = name;
    const std::filesystem::path path = file_.parent_path() / "iv" / file;
    std::error_code error;
    if (file.find("..") != std::string::npos || std::filesystem::path(file).is_absolute() ||
        !std::filesystem::is_regular_file(path, error)) {
      loss_.drop(place, "body '" + file + "'", "the file is not there");
      return link;
    }
    if (path.extension() != ".xml") {
      link.visuals.push_back(mesh_shape(file));
      link.collisions = link.visuals;
      return link;
    }
    files_.spend(path);
    TrackedXml document = TrackedXml::read(path, loss_);
    const XmlElement root = document.root();
    Shape shape = mesh_shape("");
    if (const auto geometry = root.child("geometryFile")) {
      geometry->attribute("type");
      shape.mesh = "iv/" + geometry->text();
    }
    if (const auto scale = root.child("geometryScaling")) shape.scale *= scale->text_number();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string one = std::string("geometryScaling") + "XYZ"[axis];
      if (const auto scale = root.child(one.c_str())) shape.scale[axis] *= scale->text_number();
    }
    if (const auto offset = root.child("geometryOffset")) {
      if (const auto transform = offset->child("transform")) shape.X_LS = transform_of(*transform);
    }
    if (const auto material = root.child("material")) shape.material = material->text();
    Inertial inertial;
    inertial.mass = kDefaultMass;
    if (const auto mass = root.child("mass")) {
      inertial.mass = kGram * mass->text_number();
    } else {
      root.child("mass");
      loss_.approximate(root.place(), "no mass", "0.3 kg, as GraspIt! takes it");
    }
    if (const auto center = root.child("cog")) {
      const auto n = center->text_numbers(3);
      inertial.X_LI.translation() = kMillimetre * Eigen::Vector3d(n[0], n[1], n[2]);
    }
    if (const auto matrix = root.child("inertia_matrix")) {
      const auto n = matrix->text_numbers(9);
      const Eigen::Matrix3d given = Eigen::Map<const Eigen::Matrix3d>(n.data());
      if (!given.isApprox(given.transpose(), 1e-6)) matrix->approximate("made symmetric");
      // It is divided by the mass, in mm^2.
      inertial.inertia =
          inertial.mass * kMillimetre * kMillimetre * 0.5 * (given + given.transpose());
    }
    link.inertial = inertial;
    for (const char* simulated :
         {"youngs", "useFlockOfBirds", "normalCompliance", "shearCompliance"}) {
      if (const auto one = root.child(simulated)) one->drop("the softness of bodies is not kept");
    }
    if (!shape.mesh.empty()) {
      link.visuals.push_back(shape);
      link.collisions.push_back(shape);
    }
    document.finish();
    return link;
  }
  static Shape mesh_shape(const std::string& file) {
    Shape shape;
    shape.kind = Shape::Kind::kMesh;
    shape.mesh = file.empty() ? "" : "iv/" + file;
    shape.scale = Eigen::Vector3d::Constant(kMillimetre);
    return shape;
  }

  void read_chain(const XmlElement& element, std::size_t number) {
    RigidTransform X = RigidTransform::Identity();
    if (const auto transform = element.child("transform")) X = transform_of(*transform);
    std::vector<JointDescription> joints;
    for (const XmlElement& one : element.children("joint")) {
      joints.push_back(read_joint(one, fmt::format("chain{}_joint{}", number, joints.size())));
    }
    std::size_t used = 0, links = 0;
    std::string above = "palm";
    const std::map<std::string, std::size_t> counts{
        {"Revolute", 1}, {"Prismatic", 1}, {"Universal", 2}, {"Ball", 3}, {"Fixed", 0}};
    for (const XmlElement& one : element.children("link")) {
      const std::string type = one.attribute("dynamicJointType").value_or("Revolute");
      const auto count = counts.find(type);
      if (count == counts.end() || used + count->second > joints.size()) {
        one.fail("a link of type '" + type + "' has no joints left for it",
                 "Write Revolute, Prismatic, Universal, Ball or Fixed, and as many joints");
      }
      const std::string name = fmt::format("chain{}_link{}", number, links++);
      refuse_many_links(robot_.links.size() + count->second, element.place());
      for (std::size_t i = 0; i < count->second; ++i) {
        JointDescription joint = joints[used++];
        joint.parent = above;
        const bool is_last = i + 1 == count->second;
        joint.child = is_last ? name : fmt::format("{}_between{}", name, i);
        joint.X_PJ = X * joint.X_PJ;
        X = RigidTransform::Identity();
        if (!is_last) robot_.links.push_back({joint.child, {}, {}, {}});
        above = joint.child;
        robot_.joints.push_back(std::move(joint));
      }
      if (count->second == 0) {
        JointDescription joint;
        joint.name = name + "_fixed";
        joint.parent = above;
        joint.child = name;
        joint.X_PJ = X;
        X = RigidTransform::Identity();
        robot_.joints.push_back(std::move(joint));
      }
      above = name;
      if (const auto rule = one.attribute("collisionRule")) {
        one.drop_attribute("targetChain", "pairs of links that may touch are not kept of it");
        one.drop_attribute("targetLink", "pairs of links that may touch are not kept of it");
      }
      one.attribute("sensorType");
      robot_.links.push_back(read_body(name, one.text(), one.place()));
    }
    if (used < joints.size()) {
      loss_.drop(element.place(), fmt::format("{} joints", joints.size() - used),
                 "no link is moved by them");
    }
    for (const XmlElement& one : element.children("filter")) {
      read_cell(one, fmt::format("chain{}_link{:.0f}", number, std::trunc(one.text_number())));
    }
  }

  JointDescription read_joint(const XmlElement& element, const std::string& name) {
    JointDescription joint;
    joint.name = name;
    const std::string type = element.attribute("type").value_or("Revolute");
    const bool turns = type == "Revolute";
    if (!turns && type != "Prismatic") {
      element.fail("joint type '" + type + "' is none of GraspIt!'s",
                   "Write Revolute or Prismatic");
    }
    joint.kind = turns ? Kind::kRevolute : Kind::kPrismatic;
    joint.axis_J = Eigen::Vector3d::UnitZ();
    std::map<std::string, double> values;
    std::optional<Variable> variable;
    for (const char* tag : {"theta", "d", "a", "alpha"}) {
      const auto one = element.child(tag);
      if (!one) element.fail(std::string("the joint has no ") + tag, "Give it");
      const bool is_variable = std::string(tag) == (turns ? "theta" : "d");
      if (is_variable) {
        variable = variable_of(*one);
        if (!variable) {
          one->fail("'" + one->text() + "' is none of dN, dN*k, dN+c, dN*k+c", "Name a motor");
        }
      } else {
        values[tag] = one->text_number();
      }
    }
    // Distal: Rz(theta) Tz(d) Tx(a) Rx(alpha); it moves about z of the frame before.
    const double theta = kDegree * (turns ? variable->offset : values["theta"]);
    const double d = kMillimetre * (turns ? values["d"] : variable->offset);
    if (turns) {
      joint.X_PJ = turned(theta, Eigen::Vector3d::UnitZ());
      joint.X_JC = moved({0, 0, d});
    } else {
      joint.X_PJ = turned(theta, Eigen::Vector3d::UnitZ()) * moved({0, 0, d});
    }
    joint.X_JC = joint.X_JC * moved({kMillimetre * values["a"], 0, 0}) *
                 turned(kDegree * values["alpha"], Eigen::Vector3d::UnitX());
    const double unit = turns ? kDegree : kMillimetre;
    if (const auto one = element.child("minValue")) joint.lower = unit * one->text_number();
    if (const auto one = element.child("maxValue")) joint.upper = unit * one->text_number();
    if (const auto one = element.child("viscousFriction")) {
      one->drop("it is in GraspIt!'s own scale");
    }
    if (const auto one = element.child("CoulombFriction")) {
      one->drop("it is in GraspIt!'s own scale");
    }
    if (const auto one = element.child("springStiffness")) {
      joint.stiffness = one->text_number() * (turns ? kMillimetre : 1 / kMillimetre);
    }
    if (const auto one = element.child("restValue")) joint.rest = unit * one->text_number();
    if (const auto one = element.child("restVal")) {
      one->drop("GraspIt! reads restValue, not restVal");
    }
    if (static_cast<std::size_t>(variable->motor) >= motors_.size()) {
      element.fail(fmt::format("there is no motor d{}", variable->motor), "Add a dof, or mend it");
    }
    const Motor& motor = motors_[static_cast<std::size_t>(variable->motor)];
    if (motor.type == 'b') joint.break_away = motor.break_away;
    joint.effort = motor.effort / kEffortUnit * (turns ? kMillimetre : 1);
    of_motor_.push_back({name, *variable});
    return joint;
  }

  // The first joint of a motor with factor 1, else the first, stands for it; others follow.
  void name_motors() {
    std::map<std::string, JointDescription*> by_name;
    for (JointDescription& joint : robot_.joints) by_name.emplace(joint.name, &joint);
    std::vector<std::vector<const std::pair<std::string, Variable>*>> moved(motors_.size());
    for (const auto& one : of_motor_) {
      moved[static_cast<std::size_t>(one.second.motor)].push_back(&one);
    }
    for (std::size_t i = 0; i < motors_.size(); ++i) {
      const std::pair<std::string, Variable>* leader = nullptr;
      for (const auto* one : moved[i]) {
        if (!leader || (leader->second.factor != 1 && one->second.factor == 1)) leader = one;
      }
      if (!leader) {
        loss_.drop(root_.place(), fmt::format("motor d{}", i), "no joint is moved by it");
        continue;
      }
      robot_.actuators.push_back(
          {fmt::format("d{}", i), leader->first, 1 / leader->second.factor, {}, ""});
      for (const auto* one : moved[i]) {
        const auto joint = by_name.find(one->first);
        if (joint == by_name.end()) continue;  // no link is moved by it
        if (one == leader) {
          joint->second->break_away.reset();
        } else {
          joint->second->follows =
              Follows{leader->first, one->second.factor / leader->second.factor, 0};
        }
      }
      if (motors_[i].type == 'c') {
        loss_.approximate(root_.place(), fmt::format("compliant motor d{}", i),
                          "joints that follow stiffly");
      }
    }
  }

  void read_cell(const XmlElement& element, const std::string& link) {
    element.attribute("type");
    std::string params = element.needed("params");
    for (char& c : params) {
      if (c == ',') c = ' ';
    }
    const auto n = parse_numbers(params, 6, element.place());
    const Eigen::Vector3d low(n[0], n[1], n[2]), high(n[3], n[4], n[5]);
    Sensor cell;
    cell.name = fmt::format("cell{}", robot_.sensors.size());
    cell.kind = "tactile";
    cell.link = link;
    cell.X_LS.translation() = kMillimetre * 0.5 * (low + high);
    cell.size = kMillimetre * (high - low).cwiseAbs();
    robot_.sensors.push_back(std::move(cell));
  }
  void read_pair(const XmlElement& element) {
    const auto link_of = [&](const char* chain, const char* link) {
      const double number = element.needed_number(chain);
      return number < 0 ? std::string("palm")
                        : fmt::format("chain{:.0f}_link{:.0f}", std::trunc(number),
                                      std::trunc(element.needed_number(link)));
    };
    robot_.disabled_collisions.emplace_back(link_of("body1_chain", "body1_link"),
                                            link_of("body2_chain", "body2_link"));
  }

  const XmlElement root_;
  const std::filesystem::path file_;
  LossReport& loss_;
  FileBudget files_;
  RobotDescription robot_;
  std::vector<Motor> motors_;
  std::vector<std::pair<std::string, Variable>> of_motor_;  // joint and what moves it
};

class GraspIt : public RobotFormat {
 public:
  std::string name() const override { return "graspit"; }
  bool recognises(const XmlElement& root) const override {
    return root.name() == "robot" && (root.child("palm") || root.child("chain"));
  }
  std::string ending() const override { return ".xml"; }
  RobotDescription read(const std::filesystem::path& file, LossReport& loss) const override {
    TrackedXml document = TrackedXml::read(file, loss);
    RobotDescription robot = GraspItReader(document.root(), file, loss).read();
    document.finish();
    tree_order(robot);
    return robot;
  }
};

}  // namespace

std::unique_ptr<RobotFormat> graspit_format() { return std::make_unique<GraspIt>(); }

}  // namespace prehend::robot::formats
