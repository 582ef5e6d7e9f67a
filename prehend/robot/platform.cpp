#include "prehend/robot/platform.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/geometry/errors.h"
#include "prehend/robot/at_line.h"
#include "prehend/robot/pose_yaml.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {
namespace {

constexpr const char* kArm = "arm_";
constexpr const char* kHand = "hand_";

/// Adds a robot's links and joints with `prefix` before their names; the number of its root link.
int append(const RobotModel& part, const std::string& prefix, RobotModel& whole) {
  const int first_link = static_cast<int>(whole.links.size());
  const int first_joint = static_cast<int>(whole.joints.size());
  for (Link link : part.links) {
    link.name = prefix + link.name;
    whole.links.push_back(std::move(link));
  }
  for (Joint joint : part.joints) {
    joint.name = prefix + joint.name;
    joint.parent += first_link;
    joint.child += first_link;
    if (joint.mimic) joint.mimic->joint += first_joint;
    whole.joints.push_back(std::move(joint));
  }
  whole.remarks.insert(whole.remarks.end(), part.remarks.begin(), part.remarks.end());
  return first_link;
}

constexpr double kAcceleration = 5;  // rad/s^2 or m/s^2, where the file says nothing
constexpr double kAlong = 1e-9;      // rad: directions nearer than this are one

/// A value for each of the arm's joints.
Positions read_joints(text::YamlMap& map, const KinematicChain& chain, const std::string& mend) {
  Positions values = chain.middle();
  for (int i = 0; i < chain.size(); ++i) {
    const std::string joint =
        chain.joints()[static_cast<std::size_t>(i)].name.substr(std::string(kArm).size());
    if (!map.child(joint).IsDefined()) map.fail(joint, "is missing", mend);
    map.read(joint, values[i]);
  }
  map.finish();
  return values;
}

Positions read_acceleration(const YAML::Node& node, const std::filesystem::path& path,
                            const KinematicChain& chain) {
  if (!node.IsDefined()) return Positions::Constant(chain.size(), kAcceleration);
  text::YamlMap map(node, path, "platform.acceleration");
  const Positions values = read_joints(map, chain, "Give every joint's, or leave all out");
  for (int i = 0; i < chain.size(); ++i) {
    if (values[i] > 0 && std::isfinite(values[i])) continue;
    const std::string& joint = chain.joints()[static_cast<std::size_t>(i)].name;
    map.fail(joint.substr(std::string(kArm).size()), "is not positive and finite",
             "Give what the joint can do [rad/s^2 or m/s^2]");
  }
  return values;
}

Positions read_home(const YAML::Node& node, const std::filesystem::path& path,
                    const std::string& place, const KinematicChain& chain) {
  text::YamlMap map(node, path, place);
  const Positions q = read_joints(map, chain, "Give every joint's position");
  if (const std::string problem = chain.limit_problem(q); !problem.empty()) {
    throw geometry::InputError(
        path.string() + ":" + std::to_string(node.Mark().line + 1) + ": " + place + ": " + problem,
        "Stay within the URDF's limits");
  }
  return q;
}

/// That base and flange are of the arm, and what is between them can move and be timed.
void check_arm(const text::YamlMap& map, const RobotModel& arm, const std::string& file,
               const std::string& base, const std::string& flange) {
  at_line(map, "base", [&] { return arm.link_index(base); });
  at_line(map, "flange", [&] { return arm.link_index(flange); });
  const KinematicChain chain =
      at_line(map, "flange", [&] { return KinematicChain(arm, base, flange); });
  for (const ChainJoint& joint : chain.joints()) {
    if (std::isfinite(joint.max_velocity)) continue;
    map.fail("arm", ": joint '" + joint.name + "' of " + file + " has no velocity limit",
             "Write velocity=\"...\" [rad/s or m/s] into its <limit>");
  }
}

}  // namespace

RobotModel Platform::with_hand_at(const Eigen::Ref<const Eigen::VectorXd>& all) const {
  const std::size_t count = hand.model.joints.size();
  if (static_cast<std::size_t>(all.size()) != count) {
    throw std::invalid_argument("Platform::with_hand_at: hand '" + hand.name + "' has " +
                                std::to_string(count) + " joints, not " +
                                std::to_string(all.size()));
  }
  RobotModel fixed = model;
  const std::size_t first = fixed.joints.size() - count;  // the hand's come last
  for (std::size_t i = 0; i < count; ++i) {
    Joint& joint = fixed.joints[first + i];
    joint.X_PJ = joint.pose_at(all[static_cast<Eigen::Index>(i)]);
    joint.kind = Joint::Kind::kFixed;
    joint.mimic.reset();
  }
  return fixed;
}

std::optional<Eigen::Vector3d> Platform::fixed_approach(const Preshape& preshape) const {
  const KinematicChain chain = arm_chain();
  std::vector<geometry::RigidTransform> poses;
  chain.forward(chain.middle(), poses);
  const Eigen::Vector3d tool_F = X_FG(preshape).linear().col(2);
  Eigen::Vector3d approach_B = poses.back().linear() * (chain.X_JT().linear() * tool_F);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!chain.joints()[i].is_revolute) continue;
    const Eigen::Vector3d axis_B = poses[i].linear() * chain.joints()[i].axis_J;
    if (axis_B.cross(approach_B).norm() > kAlong) return std::nullopt;
  }
  Eigen::Vector3d approach_W = X_WB.linear() * approach_B;
  for (double& component : approach_W) {
    if (std::abs(component) < kAlong) component = 0;
  }
  return approach_W.normalized();
}

void Platform::set_gripper(const GripperModel& gripper) {
  const double before = hand.gripper->max_opening / 2, after = gripper.max_opening / 2;
  hand.gripper = gripper;
  for (HandPad& pad : hand.pads) pad = flat_pad(pad.name, pad.link, pad.X_LP, gripper.pad);
  for (Preshape& preshape : hand.preshapes) {
    preshape.open[0] = preshape.open[0] == before ? after : std::min(preshape.open[0], after);
  }
  const auto fit = [&](RobotModel& robot, const std::string& prefix) {
    for (Joint& joint : robot.joints) {
      if (joint.kind != Joint::Kind::kPrismatic || !joint.name.starts_with(prefix)) continue;
      joint.upper = after;
      joint.max_velocity = gripper.max_speed / 2;
    }
  };
  fit(hand.model, "");
  fit(model, kHand);
}

const Platform::Home& Platform::home(const std::string& home_name) const {
  std::vector<std::string> names;
  for (const Home& one : homes) {
    if (one.name == home_name) return one;
    names.push_back(one.name);
  }
  throw geometry::InputError("Platform '" + name + "' has no home '" + home_name + "'",
                             text::nearest_match_mend(home_name, names));
}

Platform read_platform(const std::filesystem::path& path) {
  Platform platform;
  const YAML::Node file = text::load_yaml_map(path);
  if (!file["arm"] && file["fingers"]) {
    throw geometry::InputError(path.string() + " is a hand, and no platform: it has no arm",
                               "Write a platform's file with `arm` and `hand`, as kr5_sdh.yaml is, "
                               "or plan for the hand alone");
  }
  text::YamlMap map(file, path, "platform");
  std::string arm, base, flange, hand;
  map.read("name", platform.name);
  map.read("arm", arm);
  map.read("base", base);
  map.read("flange", flange);
  map.read("hand", hand);
  const YAML::Node mount = map.child("mount"), world = map.child("world"),
                   camera = map.child("camera"), homes = map.child("homes"),
                   acceleration = map.child("acceleration");
  map.choose("hand_port", {{"joints", HandPort::kJoints}, {"gripper", HandPort::kGripper}},
             platform.hand_port);
  map.finish();
  for (const auto& [key, value] :
       {std::pair{"name", &platform.name}, std::pair{"arm", &arm}, std::pair{"base", &base},
        std::pair{"flange", &flange}, std::pair{"hand", &hand}}) {
    if (value->empty()) map.fail(key, "is missing", "Add `" + std::string(key) + ": ...`");
  }
  if (mount.IsDefined()) platform.X_FH = read_pose(mount, path, "platform.mount");
  if (world.IsDefined()) platform.X_WB = read_pose(world, path, "platform.world");
  if (camera.IsDefined()) platform.X_FC = read_pose(camera, path, "platform.camera");

  const std::filesystem::path folder = path.parent_path();
  const RobotModel arm_model = at_line(map, "arm", [&] { return read_urdf(folder / arm); });
  check_arm(map, arm_model, arm, base, flange);
  platform.hand = at_line(map, "hand", [&] { return read_hand_model(folder / hand); });
  platform.model.name = platform.name;
  append(arm_model, kArm, platform.model);
  const int flange_link = platform.model.link_index(kArm + flange);
  platform.base = kArm + base;
  platform.flange = kArm + flange;

  // The mount comes before the hand's own joints, so that those stand last.
  Joint joint;
  joint.name = "mount";
  joint.parent = flange_link;
  joint.child = static_cast<int>(platform.model.links.size());
  joint.X_PJ = platform.X_FH;
  platform.model.joints.push_back(joint);
  append(platform.hand.model, kHand, platform.model);

  const KinematicChain chain = platform.arm_chain();
  platform.acceleration = read_acceleration(acceleration, path, chain);
  if (platform.hand_port == HandPort::kGripper && !platform.hand.gripper) {
    map.fail("hand_port", "is gripper, but " + hand + " has none",
             "Name a hand with `gripper`, as pg70.yaml, or leave hand_port out");
  }
  if (!homes.IsDefined() || !homes.IsMap() || homes.size() == 0) {
    map.fail("homes", "is missing or empty", "Give at least one position of the arm's joints");
  }
  for (const auto& entry : homes) {
    const std::string name = entry.first.Scalar();
    platform.homes.push_back(
        {name, read_home(entry.second, path, "platform.homes." + name, chain)});
  }
  const auto is_home = [](const Platform::Home& one) { return one.name == "home"; };
  if (std::none_of(platform.homes.begin(), platform.homes.end(), is_home)) {
    map.fail("homes", "has none that is called home",
             "Call one so: where the arm stands unless another is asked for");
  }
  return platform;
}

}  // namespace prehend::robot
