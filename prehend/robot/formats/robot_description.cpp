#include "prehend/robot/formats/robot_description.h"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

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
    Leader leader{static_cast<int>(i), 1, 0};
    const JointDescription* joint = &joints_[i];
    for (int depth = 0; joint->follows; ++depth) {
      const auto found = joints.find(joint->follows->joint);
      if (found == joints.end() || depth > kMostLeaders) {
        throw InputError("Joint '" + joint->name + "' follows '" + joint->follows->joint +
                             (found == joints.end() ? "', which is not there" : "' in a circle"),
                         "Name a joint that moves by itself");
      }
      leader.offset += leader.multiplier * joint->follows->offset;
      leader.multiplier *= joint->follows->multiplier;
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
    const double q =
        leader.multiplier * positions[static_cast<std::size_t>(leader.joint)] + leader.offset;
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
