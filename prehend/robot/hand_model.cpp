#include "prehend/robot/hand_model.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "prehend/geometry/errors.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot {
namespace {

std::size_t place(int index) { return static_cast<std::size_t>(index); }

/// Position of `name` among `names`. @throws geometry::InputError.
int find_name(const std::string& name, const std::vector<std::string>& names,
              const std::string& what) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  throw geometry::InputError(what + " '" + name + "' is not there",
                             text::nearest_match_mend(name, names));
}

}  // namespace

double HandModel::mass() const {
  double sum = 0;
  for (const Link& link : model.links) sum += link.mass;
  return sum;
}

std::vector<std::string> HandModel::actuated_names() const {
  std::vector<std::string> names;
  for (const int joint : actuated) names.push_back(model.joints[place(joint)].name);
  return names;
}

const Preshape& HandModel::preshape(const std::string& preshape_name) const {
  std::vector<std::string> names;
  for (const Preshape& shape : preshapes) names.push_back(shape.name);
  return preshapes[place(find_name(preshape_name, names, "Preshape of hand '" + name + "'"))];
}

int HandModel::actuated_index(const std::string& joint) const {
  return find_name(joint, actuated_names(), "Actuated joint of hand '" + name + "'");
}

Eigen::VectorXd HandModel::all_positions(const Eigen::Ref<const Eigen::VectorXd>& positions) const {
  if (positions.size() != size()) {
    throw std::invalid_argument("HandModel::all_positions: hand '" + name + "' has " +
                                std::to_string(size()) + " actuated joints, not " +
                                std::to_string(positions.size()));
  }
  Eigen::VectorXd all = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.joints.size()));
  for (int i = 0; i < size(); ++i) all[actuated[place(i)]] = positions[i];
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    // Over chains of mimics to the joint that a motor moves.
    double multiplier = 1, offset = 0;
    const Joint* at = &model.joints[i];
    if (!at->mimic) continue;
    int leader = -1;
    while (at->mimic) {
      offset += multiplier * at->mimic->offset;
      multiplier *= at->mimic->multiplier;
      leader = at->mimic->joint;
      at = &model.joints[place(leader)];
    }
    all[static_cast<Eigen::Index>(i)] = multiplier * all[leader] + offset;
  }
  return all;
}

void HandModel::link_poses(const Eigen::Ref<const Eigen::VectorXd>& all,
                           std::vector<geometry::RigidTransform>& poses) const {
  poses.resize(model.links.size());
  poses[0] = geometry::RigidTransform::Identity();
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    poses[place(joint.child)] =
        poses[place(joint.parent)] * joint.pose_at(all[static_cast<Eigen::Index>(i)]);
  }
}

std::string HandModel::limit_problem(const Eigen::Ref<const Eigen::VectorXd>& all) const {
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const double position = all[static_cast<Eigen::Index>(i)];
    const bool low = !(position >= joint.lower - 1e-9);
    if (joint.kind == Joint::Kind::kFixed || (!low && position <= joint.upper + 1e-9)) continue;
    const bool turns = joint.kind == Joint::Kind::kRevolute;
    const double scale = turns ? 57.29577951308232 : 1e3;
    const char* unit = turns ? "deg" : "mm";
    char text[160];
    std::snprintf(text, sizeof text, "joint '%.60s' at %.1f %s is beyond %.1f %s",
                  joint.name.c_str(), scale * position, unit,
                  scale * (low ? joint.lower : joint.upper), unit);
    return text;
  }
  return {};
}

HandModel parallel_hand(const GripperModel& gripper) {
  HandModel hand;
  hand.name = gripper.name;
  hand.model.name = gripper.name;
  hand.model.links = {{"palm", gripper.mass - 2 * gripper.jaw_mass, {}},
                      {"left_finger", gripper.jaw_mass, {}},
                      {"right_finger", gripper.jaw_mass, {}}};
  for (int finger = 0; finger < 2; ++finger) {
    Joint joint;
    joint.name = finger == 0 ? "opening" : "right";
    joint.kind = Joint::Kind::kPrismatic;
    joint.parent = 0;
    joint.child = 1 + finger;
    joint.axis_J = Eigen::Vector3d(0, finger == 0 ? 1 : -1, 0);
    joint.lower = 0;
    joint.upper = gripper.max_opening / 2;
    if (finger > 0) joint.mimic = Mimic{0, 1, 0};
    hand.model.joints.push_back(joint);
    hand.fingers.push_back({hand.model.links[place(1 + finger)].name, {1 + finger}});
    const geometry::RigidTransform X_LP = geometry::RigidTransform::Identity();
    hand.pads.push_back(flat_pad(finger == 0 ? "left" : "right", 1 + finger, X_LP, gripper.pad));
  }
  hand.actuated = {0};
  Preshape open;
  open.name = "open";
  open.open = Eigen::VectorXd::Constant(1, gripper.max_opening / 2);
  open.closing = {{-1, -1}};
  hand.preshapes = {open};
  hand.friction = gripper.pad.law.dynamic_friction;
  hand.gripper = gripper;
  return hand;
}

}  // namespace prehend::robot
