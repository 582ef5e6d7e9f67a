#include "eval/motion/planning_robot.h"

#include <algorithm>
#include <tuple>

#include <tinyxml2.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/srdf.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::eval {
namespace {

using geometry::InputError;

/// Base and tip of a group's chain.
std::pair<std::string, std::string> chain_of(const std::filesystem::path& srdf,
                                             const std::string& group) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(srdf.c_str()) != tinyxml2::XML_SUCCESS || !document.RootElement()) {
    throw InputError("'" + srdf.string() + "' is no SRDF: " + document.ErrorStr(), "Mend it");
  }
  for (const auto* one = document.RootElement()->FirstChildElement("group"); one;
       one = one->NextSiblingElement("group")) {
    const char* name = one->Attribute("name");
    const auto* chain = one->FirstChildElement("chain");
    if (!name || group != name || !chain) continue;
    const char *base = chain->Attribute("base_link"), *tip = chain->Attribute("tip_link");
    if (base && tip) return {base, tip};
  }
  throw InputError("'" + srdf.string() + "' has no group '" + group + "' with a chain",
                   "Add <group name=\"" + group + "\"><chain base_link=... tip_link=.../></group>");
}

}  // namespace

PlanningRobot read_planning_robot(const std::filesystem::path& urdf,
                                  const std::filesystem::path& srdf, const std::string& group) {
  PlanningRobot robot;
  robot.model = robot::read_urdf(urdf);
  std::tie(robot.base, robot.tip) = chain_of(srdf, group);
  robot::formats::RobotDescription description;
  for (const robot::Link& link : robot.model.links) {
    description.links.push_back({link.name, {}, {}, {}});
  }
  robot::formats::LossReport loss;
  robot::formats::read_srdf(srdf, description, loss);
  robot.may_touch = description.disabled_collisions;
  robot::KinematicChain(robot.model, robot.base, robot.tip);  // throws where there is none
  return robot;
}

PlanningRobot with_fixed(const PlanningRobot& robot,
                         const std::map<std::string, double>& positions) {
  PlanningRobot fixed = robot;
  const robot::KinematicChain chain(robot.model, robot.base, robot.tip);
  for (robot::Joint& joint : fixed.model.joints) {
    const auto position = positions.find(joint.name);
    const bool is_beside = std::ranges::find(chain.joints(), joint.name,
                                             &robot::ChainJoint::name) == chain.joints().end();
    if (position == positions.end() || !is_beside) continue;
    joint.X_PJ = joint.pose_at(position->second);
    joint.kind = robot::Joint::Kind::kFixed;
    joint.mimic.reset();
  }
  return fixed;
}

}  // namespace prehend::eval
