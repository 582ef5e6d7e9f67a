#include "prehend/robot/formats/mjcf_writer.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/mjcf_size.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using Kind = JointDescription::Kind;

constexpr const char* kWorld = "world";  // MJCF's own name of what everything hangs on

std::string quaternion_text(const RigidTransform& X) {
  const Eigen::Quaterniond q(X.linear());
  return fmt::format("{} {} {} {}", number_text(q.w()), number_text(q.x()), number_text(q.y()),
                     number_text(q.z()));
}
std::string place_text(const RigidTransform& X) {
  return fmt::format("pos=\"{}\" quat=\"{}\"", numbers_text(X.translation()), quaternion_text(X));
}
std::string named(const std::string& name) { return "name=\"" + escaped(name) + "\""; }

class MjcfWriter {
 public:
  MjcfWriter(const RobotDescription& robot, LossReport& loss) : robot_(robot), loss_(loss) {
    order_ = tree_order(robot);
    refuse_what_is_not_read();
  }

  std::string text() {
    const std::string bodies = world();
    std::string text = fmt::format("<mujoco model=\"{}\">\n", escaped(robot_.name));
    text += fmt::format("  <compiler angle=\"radian\" inertiafromgeom=\"false\"{}/>\n",
                        has_no_mass_ ? " boundmass=\"1e-9\" boundinertia=\"1e-12\"" : "");
    if (!assets_.empty()) text += "  <asset>\n" + assets_ + "  </asset>\n";
    text += "  <worldbody>\n" + bodies + "  </worldbody>\n";
    for (const Manipulator& one : robot_.manipulators) {
      loss_.drop("manipulator '" + one.name + "'", "manipulator", "MJCF has no manipulators");
    }
    for (const Posture& one : robot_.postures) {
      loss_.drop("posture '" + one.name + "'", "posture", "MJCF has them for all joints only");
    }
    section(text, "equality", equalities());
    section(text, "contact", exclusions());
    section(text, "actuator", actuators());
    section(text, "sensor", sensors_);
    return text + "</mujoco>\n";
  }

 private:
  void refuse_what_is_not_read() const {
    const bool is_on_world = order_.front() == kWorld;
    // mujoco, worldbody, and what is of the last body; the world is none.
    constexpr std::size_t kMostInChain = 96;
    refuse_deep_links(robot_, is_on_world ? kMostInChain : kMostInChain - 1, "MJCF");
    if (order_.size() - (is_on_world ? 1 : 0) > kMostMjcfBodies) {
      throw geometry::InputError(
          fmt::format("The robot has more than {} links, and prehend reads no MJCF of more: the "
                      "time of MuJoCo's compiler is as their square",
                      kMostMjcfBodies),
          "Write URDF, SDF or .robot.json");
    }
  }

  static void section(std::string& text, const char* name, const std::string& lines) {
    if (!lines.empty()) text += fmt::format("  <{0}>\n{1}  </{0}>\n", name, lines);
  }

  std::string world() {
    const std::string& root = order_.front();
    if (root == kWorld) {
      const LinkDescription& link = *robot_.link(root);
      if (link.inertial) loss_.drop("link 'world'", "inertial", "the world has none");
      return shapes(link, "    ") + sensors_on(root, "    ") + children(root, "    ");
    }
    loss_.approximate("link '" + root + "'", "root", "held by the world, which MJCF has always");
    return body(root, nullptr, "    ");
  }

  std::string children(const std::string& parent, const std::string& indent) {
    std::string text;
    for (const JointDescription& joint : robot_.joints) {
      if (joint.parent == parent) text += body(joint.child, &joint, indent);
    }
    return text;
  }

  std::string body(const std::string& name, const JointDescription* joint,
                   const std::string& indent) {
    const LinkDescription& link = *robot_.link(name);
    RigidTransform X = joint ? joint->X_PJ : RigidTransform::Identity();
    if (joint && is_stuck(*joint) && joint->kind == Kind::kRevolute) {
      X.rotate(Eigen::AngleAxisd(*joint->lower, joint->axis_J));
    } else if (joint && is_stuck(*joint) && joint->kind == Kind::kPrismatic) {
      X.translate(*joint->lower * joint->axis_J);
    }
    if (joint) X = X * joint->X_JC;
    std::string text = fmt::format("{}<body {} {}>\n", indent, named(name), place_text(X));
    const std::string deeper = indent + "  ";
    if (joint) text += joint_text(*joint, deeper);
    if (link.inertial) {
      const Inertial& inertial = *link.inertial;
      const Eigen::Matrix3d R = inertial.X_LI.linear();
      Eigen::Matrix3d I = R * inertial.inertia * R.transpose();
      const Eigen::Vector3d principal =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
      if (!(principal[0] > 0)) {
        loss_.approximate("link '" + name + "'", "inertia",
                          "no body has it, nor does MuJoCo take it: that of a ball of 10 mm");
        I = 0.4 * inertial.mass * 0.01 * 0.01 * Eigen::Matrix3d::Identity();
      }
      text += fmt::format("{}<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {}\"/>\n", deeper,
                          numbers_text(inertial.X_LI.translation()), number_text(inertial.mass),
                          numbers_text(I.diagonal()),
                          fmt::format("{} {}", number_text(I(0, 1)), number_text(I(0, 2))),
                          number_text(I(1, 2)));
    } else if (joint && joint->kind != Kind::kFixed) {
      loss_.approximate("link '" + name + "'", "no inertial",
                        "1e-9 kg: MuJoCo moves nothing without a mass");
      has_no_mass_ = true;
    }
    text += shapes(link, deeper) + sensors_on(name, deeper) + children(name, deeper);
    return text + indent + "</body>\n";
  }

  static bool is_stuck(const JointDescription& joint) {
    return joint.lower && joint.upper && !(*joint.upper > *joint.lower);
  }

  std::string joint_text(const JointDescription& joint, const std::string& indent) {
    const std::string place = "joint '" + joint.name + "'";
    if (joint.kind == Kind::kFixed) {
      if (joint.name != joint.child + "_fixed") {
        loss_.approximate(place, "name", "fixed joints have none");
      }
      return {};
    }
    if (is_stuck(joint)) {
      loss_.approximate(place, "limits", "fixed: they leave it no way");
      return {};
    }
    if (joint.kind == Kind::kPlanar) {
      loss_.drop(place, "planar joint", "MJCF has none: it is fixed");
      return {};
    }
    if (joint.kind == Kind::kFloating) {
      if (joint.parent != kWorld) {
        loss_.drop(place, "floating joint", "MJCF has them at the world only: it is fixed");
        return {};
      }
      return fmt::format("{}<freejoint {}/>\n", indent, named(joint.name));
    }
    const RigidTransform X_CJ = joint.X_JC.inverse();
    std::string text = fmt::format("{}<joint {} pos=\"{}\"", indent, named(joint.name),
                                   numbers_text(X_CJ.translation()));
    if (joint.kind == Kind::kBall) {
      text += " type=\"ball\"";
    } else {
      text +=
          fmt::format(" type=\"{}\" axis=\"{}\"", joint.kind == Kind::kRevolute ? "hinge" : "slide",
                      numbers_text(X_CJ.linear() * joint.axis_J));
      if (joint.lower && joint.upper) {
        text += fmt::format(" limited=\"true\" range=\"{} {}\"", number_text(*joint.lower),
                            number_text(*joint.upper));
      } else if (joint.lower || joint.upper) {
        loss_.drop(place, "limit", "MJCF has none on one side");
      }
    }
    if (joint.damping != 0) text += " damping=\"" + number_text(joint.damping) + "\"";
    if (joint.friction != 0) text += " frictionloss=\"" + number_text(joint.friction) + "\"";
    if (joint.stiffness) {
      text += fmt::format(" stiffness=\"{}\" springref=\"{}\"", number_text(*joint.stiffness),
                          number_text(joint.rest));
    }
    if (joint.velocity && *joint.velocity > 0) {
      loss_.drop(place, "velocity", "MJCF has no greatest speed");
    }
    if (joint.break_away) {
      loss_.approximate(place, "break-away clutch", "a coupling that never lets go");
    }
    return text + "/>\n";
  }

  std::string shapes(const LinkDescription& link, const std::string& indent) {
    std::string text;
    for (const Shape& shape : link.collisions) text += geom(link.name, shape, "", indent);
    for (const Shape& shape : link.visuals) {
      text += geom(link.name, shape, " contype=\"0\" conaffinity=\"0\" group=\"2\"", indent);
    }
    return text;
  }

  std::string geom(const std::string& link, const Shape& shape, const std::string& more,
                   const std::string& indent) {
    std::string what;
    switch (shape.kind) {
      case Shape::Kind::kBox:
        what = "type=\"box\" size=\"" + numbers_text(shape.size / 2) + "\"";
        break;
      case Shape::Kind::kSphere:
        what = "type=\"sphere\" size=\"" + number_text(shape.radius) + "\"";
        break;
      case Shape::Kind::kCylinder:
      case Shape::Kind::kCapsule:
        what = fmt::format("type=\"{}\" size=\"{} {}\"",
                           shape.kind == Shape::Kind::kCapsule ? "capsule" : "cylinder",
                           number_text(shape.radius), number_text(shape.length / 2));
        break;
      case Shape::Kind::kPlane:
        what = "type=\"plane\" size=\"1 1 0.1\"";
        break;
      case Shape::Kind::kMesh:
        what = "type=\"mesh\" mesh=\"" + escaped(asset(shape)) + "\"";
        break;
    }
    std::string name;
    if (!shape.name.empty()) {
      if (geom_names_.insert(shape.name).second) {
        name = named(shape.name) + " ";
      } else {
        loss_.drop("link '" + link + "'", "shape's name '" + shape.name + "'",
                   "another has it: MJCF's are unique");
      }
    }
    const std::string color =
        shape.color ? fmt::format(" rgba=\"{} {} {} {}\"", number_text((*shape.color)[0]),
                                  number_text((*shape.color)[1]), number_text((*shape.color)[2]),
                                  number_text((*shape.color)[3]))
                    : "";
    return fmt::format("{}<geom {}{} {}{}{}/>\n", indent, name, what, place_text(shape.X_LS), color,
                       more);
  }

  /// A mesh is named once for each file and scale.
  std::string asset(const Shape& shape) {
    const std::tuple key{shape.mesh, shape.scale.x(), shape.scale.y(), shape.scale.z()};
    auto& name = asset_names_[key];
    if (!name.empty()) return name;
    const std::string stem = std::filesystem::path(shape.mesh).stem().string();
    name = stem;
    for (int i = 2; !used_assets_.insert(name).second; ++i) name = fmt::format("{}_{}", stem, i);
    assets_ += fmt::format("    <mesh {} file=\"{}\" scale=\"{}\"/>\n", named(name),
                           escaped(shape.mesh), numbers_text(shape.scale));
    return name;
  }

  std::string sensors_on(const std::string& link, const std::string& indent) {
    static const std::set<std::string> kAtSites{"touch", "force", "torque", "accelerometer",
                                                "gyro"};
    std::string text;
    for (const Sensor& sensor : robot_.sensors) {
      if (sensor.link != link) continue;
      if (sensor.kind == "camera") {
        text +=
            fmt::format("{}<camera {} {}/>\n", indent, named(sensor.name), place_text(sensor.X_LS));
      } else if (kAtSites.count(sensor.kind) != 0) {
        const std::string size =
            sensor.size.minCoeff() > 0
                ? " type=\"box\" size=\"" + numbers_text(sensor.size / 2) + "\""
                : "";
        text += fmt::format("{}<site {} {}{}/>\n", indent, named(sensor.name + "_site"),
                            place_text(sensor.X_LS), size);
        sensors_ += fmt::format("    <{} {} site=\"{}\"/>\n", sensor.kind, named(sensor.name),
                                escaped(sensor.name + "_site"));
      } else {
        loss_.drop("sensor '" + sensor.name + "'", sensor.kind, "MJCF has none of that kind");
      }
    }
    return text;
  }

  std::string equalities() {
    std::string text;
    for (const JointDescription& joint : robot_.joints) {
      if (!joint.follows) continue;
      constexpr std::size_t kCoefficients = 5;
      std::vector<double> coefficients = joint.follows->coefficients;
      if (coefficients.size() > kCoefficients) {
        const CouplingLine coupling = coupling_line(robot_, joint);
        coefficients = coupling.line.coefficients;
        loss_.approximate("joint '" + joint.name + "'", "coupling of a degree above 4",
                          words_of_line(coupling, joint));
      }
      coefficients.resize(kCoefficients, 0);
      std::string words;
      for (const double one : coefficients) words += (words.empty() ? "" : " ") + number_text(one);
      text += fmt::format("    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{}\"/>\n",
                          escaped(joint.name), escaped(joint.follows->joint), words);
    }
    for (const Loop& loop : robot_.loops) {
      const std::string bodies = fmt::format("{} body1=\"{}\" body2=\"{}\"", named(loop.name),
                                             escaped(loop.first), escaped(loop.second));
      if (loop.kind == Loop::Kind::kPoint) {
        text += fmt::format("    <connect {} anchor=\"{}\"/>\n", bodies,
                            numbers_text(loop.X_FirstLoop.translation()));
      } else {
        text += fmt::format("    <weld {}/>\n", bodies);
      }
    }
    return text;
  }

  std::string exclusions() {
    std::string text;
    for (const auto& [first, second] : robot_.disabled_collisions) {
      text += fmt::format("    <exclude body1=\"{}\" body2=\"{}\"/>\n", escaped(first),
                          escaped(second));
    }
    return text;
  }

  std::string actuators() {
    std::string text;
    std::set<std::string> driven;
    const auto add = [&](const std::string& kind, const std::string& name, const std::string& joint,
                         double gear, const std::optional<double>& effort) {
      text += fmt::format("    <{} {} joint=\"{}\" gear=\"{}\"", kind, named(name), escaped(joint),
                          number_text(gear));
      if (effort && *effort > 0) {
        text += fmt::format(" forcelimited=\"true\" forcerange=\"{} {}\"", number_text(-*effort),
                            number_text(*effort));
      }
      text += "/>\n";
    };
    for (const Actuator& actuator : robot_.actuators) {
      if (!robot_.joint(actuator.joint) || is_stuck(*robot_.joint(actuator.joint))) {
        loss_.drop("actuator '" + actuator.name + "'", "actuator", "it moves no joint");
        continue;
      }
      driven.insert(actuator.joint);
      const std::string kind = actuator.control == "position"   ? "position"
                               : actuator.control == "velocity" ? "velocity"
                                                                : "motor";
      add(kind, actuator.name, actuator.joint, actuator.gear, actuator.effort);
    }
    for (const JointDescription& joint : robot_.joints) {
      const bool moves = joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
      if (!moves || is_stuck(joint) || !joint.effort || !(*joint.effort > 0) ||
          driven.count(joint.name) != 0)
        continue;
      if (joint.follows) {
        loss_.drop("joint '" + joint.name + "'", "effort", "it has no motor of its own");
        continue;
      }
      add("motor", joint.name + "_motor", joint.name, 1, joint.effort);
    }
    return text;
  }

  const RobotDescription& robot_;
  LossReport& loss_;
  std::vector<std::string> order_;
  std::string assets_, sensors_;
  std::map<std::tuple<std::string, double, double, double>, std::string> asset_names_;
  std::set<std::string> used_assets_, geom_names_;
  bool has_no_mass_ = false;
};

}  // namespace

std::string mjcf_text(const RobotDescription& robot, LossReport& loss) {
  return MjcfWriter(robot, loss).text();
}

}  // namespace prehend::robot::formats
