#include "prehend/robot/formats/robot_description.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {

using geometry::InputError;
using geometry::RigidTransform;

const LinkDescription* RobotDescription::link(const std::string& link_name) const {
  const auto found = std::find_if(links.begin(), links.end(),
                                  [&](const auto& one) { return one.name == link_name; });
  return found == links.end() ? nullptr : &*found;
}

const JointDescription* RobotDescription::joint_above(const std::string& link_name) const {
  for (const JointDescription& one : joints) {
    if (one.child == link_name) return &one;
  }
  return nullptr;
}

const JointDescription* RobotDescription::joint(const std::string& joint_name) const {
  const auto found = std::find_if(joints.begin(), joints.end(),
                                  [&](const auto& one) { return one.name == joint_name; });
  return found == joints.end() ? nullptr : &*found;
}

std::vector<std::string> roots(const RobotDescription& robot) {
  std::set<std::string> held;
  for (const JointDescription& joint : robot.joints) held.insert(joint.child);
  std::vector<std::string> result;
  for (const LinkDescription& link : robot.links) {
    if (held.count(link.name) == 0) result.push_back(link.name);
  }
  return result;
}

bool Follows::is_linear() const {
  return std::all_of(coefficients.begin() + 2, coefficients.end(),
                     [](double one) { return one == 0; });
}

double Follows::at(double q) const {
  double position = 0;  // Horner's scheme
  for (auto one = coefficients.rbegin(); one != coefficients.rend(); ++one) {
    position = position * q + *one;
  }
  return position;
}

CouplingLine coupling_line(const RobotDescription& robot, const JointDescription& joint) {
  const Follows& follows = *joint.follows;
  if (follows.is_linear()) {
    return {Follows(follows.joint, follows.multiplier(), follows.offset()), 0};
  }
  const JointDescription* leader = robot.joint(follows.joint);
  const bool slides = leader && leader->kind == JointDescription::Kind::kPrismatic;
  const double unlimited = slides ? 1.0 : std::numbers::pi;
  const double lower = leader ? leader->lower.value_or(-unlimited) : -unlimited;
  const double upper = leader ? leader->upper.value_or(unlimited) : unlimited;
  constexpr double kPoint = 1e-12;
  const double slope = upper - lower > kPoint
                           ? (follows.at(upper) - follows.at(lower)) / (upper - lower)
                           : follows.multiplier();
  CouplingLine result{Follows(follows.joint, slope, follows.at(lower) - slope * lower), 0};
  constexpr int kSamples = 10000;  // its largest to 1e-7 of it, where the polynomial turns once
  for (int i = 0; i <= kSamples; ++i) {
    const double q = lower + (upper - lower) * i / kSamples;
    result.deviation = std::max(result.deviation, std::abs(follows.at(q) - result.line.at(q)));
  }
  return result;
}

std::string words_of_line(const CouplingLine& coupling, const JointDescription& joint) {
  return fmt::format("the line through its ends, at most {:.3g} {} beside it", coupling.deviation,
                     joint.kind == JointDescription::Kind::kPrismatic ? "m" : "rad");
}

std::vector<std::string> tree_order(const RobotDescription& robot) {
  if (robot.links.empty()) throw InputError("The robot has no link", "Name a file that has some");
  std::set<std::string> names, joint_names;
  for (const LinkDescription& link : robot.links) {
    if (!names.insert(link.name).second) {
      throw InputError("Two links are called '" + link.name + "'", "Give each a name of its own");
    }
  }
  std::map<std::string, std::vector<std::string>> children;
  std::set<std::string> below;
  for (const JointDescription& joint : robot.joints) {
    if (!joint_names.insert(joint.name).second) {
      throw InputError("Two joints are called '" + joint.name + "'", "Give each a name of its own");
    }
    for (const std::string& link : {joint.parent, joint.child}) {
      if (names.count(link) == 0) {
        throw InputError("Joint '" + joint.name + "' is of a link '" + link + "' that is not there",
                         "Mend its parent or child");
      }
    }
    if (!below.insert(joint.child).second) {
      throw InputError("Link '" + joint.child + "' has two joints above it",
                       "A tree has one; say the other as a loop");
    }
    children[joint.parent].push_back(joint.child);
  }
  std::vector<std::string> order = roots(robot);
  if (order.size() > 1) {
    throw InputError(
        "Links '" + order[0] + "' and '" + order[1] + "' both have no joint above them",
        "Join them, or read one");
  }
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (const std::string& child : children[order[i]]) order.push_back(child);
  }
  if (order.size() != robot.links.size()) {
    throw InputError("Links are joined in a ring",
                     "Take one of its joints away, or say it as a loop");
  }
  return order;
}

namespace {

double position_of(const RobotDescription& robot, const JointDescription& joint,
                   const std::map<std::string, double>& positions, int depth) {
  if (joint.follows) {
    const JointDescription* leader = robot.joint(joint.follows->joint);
    constexpr int kDeepest = 64;
    if (!leader || depth > kDeepest) {
      throw InputError("Joint '" + joint.name + "' follows '" + joint.follows->joint +
                           (leader ? "' in a circle" : "', which is not there"),
                       "Name a joint that moves by itself");
    }
    return joint.follows->at(position_of(robot, *leader, positions, depth + 1));
  }
  const auto found = positions.find(joint.name);
  return found == positions.end() ? 0 : found->second;
}

}  // namespace

std::map<std::string, RigidTransform> link_poses(const RobotDescription& robot,
                                                 const std::map<std::string, double>& positions) {
  std::map<std::string, RigidTransform> poses;
  std::map<std::string, const JointDescription*> above;
  for (const JointDescription& joint : robot.joints) above[joint.child] = &joint;
  for (const std::string& name : tree_order(robot)) {
    const auto found = above.find(name);
    if (found == above.end()) {
      poses[name] = RigidTransform::Identity();
      continue;
    }
    const JointDescription& joint = *found->second;
    RigidTransform X = joint.X_PJ;
    if (joint.kind == JointDescription::Kind::kRevolute) {
      X.rotate(Eigen::AngleAxisd(position_of(robot, joint, positions, 0), joint.axis_J));
    } else if (joint.kind == JointDescription::Kind::kPrismatic) {
      X.translate(position_of(robot, joint, positions, 0) * joint.axis_J);
    }
    poses[name] = poses.at(joint.parent) * X * joint.X_JC;
  }
  return poses;
}

}  // namespace prehend::robot::formats
