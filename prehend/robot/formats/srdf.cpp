#include "prehend/robot/formats/srdf.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/tracked_xml.h"
#include "prehend/robot/formats/xml_text.h"

namespace prehend::robot::formats {
namespace {

/// A group's links and joints, in the order in which it names them.
struct LinkGroup {
  std::vector<std::string> links, joints;
  std::string base, tip;  // of a chain
};

class SrdfReader {
 public:
  explicit SrdfReader(RobotDescription& robot) : robot_(robot) {
    for (JointDescription& joint : robot.joints) above_[joint.child] = &joint;
    for (const LinkDescription& link : robot.links) links_.insert(link.name);
  }

  void read(const XmlElement& root) {
    root.attribute("name");
    for (const XmlElement& one : root.children("group")) {
      groups_.emplace(one.attribute("name").value_or(""), one);
    }
    for (const XmlElement& one : root.children("disable_collisions")) {
      const std::string first = one.needed("link1"), second = one.needed("link2");
      one.attribute("reason");
      if (links_.count(first) == 0 || links_.count(second) == 0) {
        one.drop("its links are not there");
        continue;
      }
      robot_.disabled_collisions.emplace_back(first, second);
    }
    for (const XmlElement& one : root.children("passive_joint")) {
      const std::string name = one.needed("name");
      bool is_there = false;
      for (JointDescription& joint : robot_.joints) {
        if (joint.name != name) continue;
        joint.passive = true;
        is_there = true;
      }
      if (!is_there) one.drop("its joint is not there");
    }
    for (const XmlElement& one : root.children("group_state")) read_posture(one);
    for (const XmlElement& one : root.children("end_effector")) read_end_effector(one);
    for (const auto& [name, element] : groups_) {
      if (used_.count(name) == 0) element.drop("groups are kept where an end effector is one");
    }
    for (const XmlElement& one : root.children("virtual_joint")) {
      one.drop("how the robot is held in its world is not its own");
    }
  }

 private:
  void read_posture(const XmlElement& element) {
    Posture posture;
    posture.name = element.needed("name");
    posture.group = element.attribute("group").value_or("");
    for (const XmlElement& one : element.children("joint")) {
      const std::string name = one.needed("name");
      const auto values = one.numbers("value", 0);
      if (!robot_.joint(name) || !values || values->size() != 1) {
        one.drop("a joint of one position, of this robot, is kept");
        continue;
      }
      posture.positions[name] = values->front();
    }
    robot_.postures.push_back(std::move(posture));
  }

  LinkGroup group(const std::string& name, int depth) {
    LinkGroup all;
    const auto found = groups_.find(name);
    if (found == groups_.end()) return all;
    const XmlElement& element = found->second;
    constexpr int kDeepest = 32;
    if (depth > kDeepest) element.fail("groups are in a ring", "Leave one of them away");
    // Groups that name one twice, which names one twice, would double each time.
    constexpr std::size_t kMostVisits = 10000;
    if (++visits_ > kMostVisits) element.fail("groups grow without end", "Name each once");
    used_.insert(name);
    for (const XmlElement& one : element.children("link")) {
      all.links.push_back(one.needed("name"));
      const auto joint = above_.find(all.links.back());
      if (joint != above_.end()) all.joints.push_back(joint->second->name);
    }
    for (const XmlElement& one : element.children("joint")) {
      all.joints.push_back(one.needed("name"));
      if (const auto* joint = robot_.joint(all.joints.back())) all.links.push_back(joint->child);
    }
    for (const XmlElement& one : element.children("chain")) {
      all.base = one.needed("base_link");
      all.tip = one.needed("tip_link");
      for (auto joint = above_.find(all.tip);
           joint != above_.end() && joint->second->child != all.base &&
           all.links.size() <= robot_.links.size();
           joint = above_.find(joint->second->parent)) {
        all.links.push_back(joint->second->child);
        all.joints.push_back(joint->second->name);
      }
    }
    for (const XmlElement& one : element.children("group")) {
      LinkGroup part = group(one.needed("name"), depth + 1);
      all.links.insert(all.links.end(), part.links.begin(), part.links.end());
      all.joints.insert(all.joints.end(), part.joints.begin(), part.joints.end());
      refuse_many_links(all.links.size(), one.place());
    }
    return all;
  }

  /// The arm's chain gives the base; which way fingers close, SRDF does not say.
  void read_end_effector(const XmlElement& element) {
    Manipulator manipulator;
    manipulator.name = element.needed("name");
    manipulator.tip = element.attribute("parent_link").value_or("");
    const LinkGroup hand = group(element.needed("group"), 0);
    manipulator.base = manipulator.tip;
    if (const auto arm = element.attribute("parent_group")) {
      const LinkGroup chain = group(*arm, 0);
      if (!chain.base.empty()) manipulator.base = chain.base;
    }
    if (!robot_.link(manipulator.tip) || !robot_.link(manipulator.base)) {
      return element.drop("its links are not there");
    }
    for (const std::string& name : hand.joints) {
      const JointDescription* joint = robot_.joint(name);
      if (joint && joint->kind != JointDescription::Kind::kFixed) {
        manipulator.closing.emplace_back(name, 0);
      }
    }
    robot_.manipulators.push_back(std::move(manipulator));
  }

  RobotDescription& robot_;
  std::map<std::string, JointDescription*> above_;  // by child
  std::map<std::string, XmlElement> groups_;
  std::set<std::string> used_, links_;
  std::size_t visits_ = 0;  // of groups
};

}  // namespace

std::filesystem::path srdf_beside(const std::filesystem::path& urdf) {
  return std::filesystem::path(urdf).replace_extension(".srdf");
}

void read_srdf(const std::filesystem::path& file, RobotDescription& robot, LossReport& loss) {
  TrackedXml document = TrackedXml::read(file, loss);
  const XmlElement root = document.root();
  if (root.name() != "robot") root.fail("<" + root.name() + "> is no SRDF's <robot>", "Mend it");
  SrdfReader(robot).read(root);
  document.finish();
}

bool needs_srdf(const RobotDescription& robot) {
  return !robot.disabled_collisions.empty() || !robot.manipulators.empty() ||
         !robot.postures.empty() ||
         std::any_of(robot.joints.begin(), robot.joints.end(),
                     [](const JointDescription& joint) { return joint.passive; });
}

void take_out_srdf(RobotDescription& robot) {
  robot.disabled_collisions.clear();
  std::erase_if(robot.manipulators, [](const Manipulator& one) {
    return one.X_TipTool.isApprox(geometry::RigidTransform::Identity(), 1e-12) &&
           std::all_of(one.closing.begin(), one.closing.end(),
                       [](const auto& joint) { return joint.second == 0; });
  });
  robot.postures.clear();
  for (JointDescription& joint : robot.joints) joint.passive = false;
}

std::string write_srdf(const RobotDescription& robot, LossReport& loss) {
  std::string text =
      fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", escaped(robot.name));
  std::set<std::string> groups;
  for (const Manipulator& one : robot.manipulators) {
    const std::string name = escaped(one.name);
    loss.keep("manipulator");
    groups.insert(one.name + "_joints");
    text += fmt::format("  <group name=\"{}_joints\">\n", name);
    for (const auto& [joint, way] : one.closing) {
      text += fmt::format("    <joint name=\"{}\"/>\n", escaped(joint));
    }
    text += "  </group>\n";
    std::string arm;
    if (one.base != one.tip) {
      arm = fmt::format(" parent_group=\"{}_arm\"", name);
      groups.insert(one.name + "_arm");
      text += fmt::format(
          "  <group name=\"{}_arm\">\n    <chain base_link=\"{}\" tip_link=\"{}\"/>\n"
          "  </group>\n",
          name, escaped(one.base), escaped(one.tip));
    }
    text +=
        fmt::format("  <end_effector name=\"{0}\" parent_link=\"{1}\" group=\"{0}_joints\"{2}/>\n",
                    name, escaped(one.tip), arm);
  }
  for (const Posture& one : robot.postures) {
    loss.keep("posture");
    std::string words;
    for (const auto& [joint, position] : one.positions) {
      words += fmt::format("    <joint name=\"{}\" value=\"{}\"/>\n", escaped(joint),
                           number_text(position));
    }
    // A group of that name, where there is none.
    if (groups.insert(one.group).second) {
      text += fmt::format("  <group name=\"{}\">\n", escaped(one.group));
      for (const auto& [joint, position] : one.positions) {
        text += fmt::format("    <joint name=\"{}\"/>\n", escaped(joint));
      }
      text += "  </group>\n";
    }
    text += fmt::format("  <group_state name=\"{}\" group=\"{}\">\n{}  </group_state>\n",
                        escaped(one.name), escaped(one.group), words);
  }
  for (const JointDescription& joint : robot.joints) {
    if (!joint.passive) continue;
    loss.keep("passive joint");
    text += fmt::format("  <passive_joint name=\"{}\"/>\n", escaped(joint.name));
  }
  for (const auto& [first, second] : robot.disabled_collisions) {
    loss.keep("pair of links that may touch");
    text += fmt::format("  <disable_collisions link1=\"{}\" link2=\"{}\" reason=\"User\"/>\n",
                        escaped(first), escaped(second));
  }
  return text + "</robot>\n";
}

}  // namespace prehend::robot::formats
