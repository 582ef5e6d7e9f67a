#include "prehend/robot/formats/robot_description.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <unordered_map>
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

void refuse_many_links(std::size_t count, const std::string& place) {
  if (count <= kMostLinks) return;
  throw InputError(place + " has more than " + std::to_string(kMostLinks) + " links or joints",
                   "No robot has so many: check the file, or split it");
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
  refuse_many_links(std::max(robot.links.size(), robot.joints.size()), "The robot");
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

void refuse_deep_links(const RobotDescription& robot, std::size_t most, const std::string& format) {
  std::unordered_map<std::string, std::string> above;
  for (const JointDescription& joint : robot.joints) above.emplace(joint.child, joint.parent);
  std::unordered_map<std::string, std::size_t> depths;
  for (const std::string& link : tree_order(robot)) {
    const auto parent = above.find(link);
    const std::size_t depth = parent == above.end() ? 0 : depths.at(parent->second) + 1;
    depths.emplace(link, depth);
    if (depth <= most) continue;
    throw InputError(
        fmt::format("Link '{}' has {} links above it, one above the other: {} has each within the "
                    "element of the one above, and more than {} are deeper than programs read XML",
                    link, depth, format, most),
        "Write URDF, SDF or .robot.json, which have links one after the other");
  }
}

namespace {

// The polynomial outer(inner(q)), by Horner's scheme.
std::vector<double> composed(const std::vector<double>& outer, const std::vector<double>& inner) {
  std::vector<double> result{0};
  for (auto one = outer.rbegin(); one != outer.rend(); ++one) {
    std::vector<double> product(result.size() + inner.size() - 1, 0.0);
    for (std::size_t i = 0; i < result.size(); ++i) {
      for (std::size_t k = 0; k < inner.size(); ++k) product[i + k] += result[i] * inner[k];
    }
    product[0] += *one;
    while (product.size() > 2 && product.back() == 0) product.pop_back();
    result = std::move(product);
  }
  return result;
}

}  // namespace

LinkPoses::LinkPoses(const RobotDescription& robot) : joints_(robot.joints) {
  std::unordered_map<std::string, int> links, joints;
  for (const LinkDescription& link : robot.links) {
    links.emplace(link.name, static_cast<int>(links.size()));
  }
  for (const std::string& name : tree_order(robot)) order_.push_back(links.at(name));
  joint_above_.assign(robot.links.size(), -1);
  for (const JointDescription& joint : joints_) {
    const int index = static_cast<int>(joints.size());
    joints.emplace(joint.name, index);
    joint_above_[static_cast<std::size_t>(links.at(joint.child))] = index;
    parent_.push_back(links.at(joint.parent));
  }
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    Leader leader{static_cast<int>(i), {}};
    const JointDescription* joint = &joints_[i];
    for (int depth = 0; joint->follows; ++depth) {
      const auto found = joints.find(joint->follows->joint);
      if (found == joints.end() || depth > kMostLeaders) {
        throw InputError("Joint '" + joint->name + "' follows '" + joint->follows->joint +
                             (found == joints.end() ? "', which is not there" : "' in a circle"),
                         "Name a joint that moves by itself");
      }
      leader.by.coefficients = composed(leader.by.coefficients, joint->follows->coefficients);
      leader.joint = found->second;
      joint = &joints_[static_cast<std::size_t>(leader.joint)];
    }
    leaders_.push_back(leader);
  }
}

std::vector<RigidTransform> LinkPoses::at(const std::vector<double>& positions) const {
  std::vector<RigidTransform> poses(joint_above_.size(), RigidTransform::Identity());
  for (const int link : order_) {
    const int above = joint_above_[static_cast<std::size_t>(link)];
    if (above < 0) continue;
    const auto index = static_cast<std::size_t>(above);
    const JointDescription& joint = joints_[index];
    const Leader& leader = leaders_[index];
    const double q = leader.by.at(positions[static_cast<std::size_t>(leader.joint)]);
    RigidTransform X = joint.X_PJ;
    if (joint.kind == JointDescription::Kind::kRevolute) {
      X.rotate(Eigen::AngleAxisd(q, joint.axis_J));
    } else if (joint.kind == JointDescription::Kind::kPrismatic) {
      X.translate(q * joint.axis_J);
    }
    poses[static_cast<std::size_t>(link)] =
        poses[static_cast<std::size_t>(parent_[index])] * X * joint.X_JC;
  }
  return poses;
}

std::map<std::string, RigidTransform> link_poses(const RobotDescription& robot,
                                                 const std::map<std::string, double>& positions) {
  const LinkPoses tree(robot);
  std::vector<double> at;
  for (const JointDescription& joint : robot.joints) {
    const auto found = positions.find(joint.name);
    at.push_back(found == positions.end() ? 0 : found->second);
  }
  const auto poses = tree.at(at);
  std::map<std::string, RigidTransform> by_name;
  for (std::size_t i = 0; i < poses.size(); ++i) by_name.emplace(robot.links[i].name, poses[i]);
  return by_name;
}

}  // namespace prehend::robot::formats
