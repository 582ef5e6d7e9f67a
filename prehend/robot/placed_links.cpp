#include "prehend/robot/placed_links.h"

#include <map>
#include <stdexcept>
#include <string>

#include "prehend/robot/link_mesh.h"

namespace prehend::robot {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

const std::string kHandPrefix =
    "hand_";  // before the names of a platform's links that are the hand's

// Positions of joints by name; those that are not named are at 0.
std::vector<RigidTransform> poses_in_root(const RobotModel& model,
                                          const std::map<std::string, double>& positions) {
  std::vector<RigidTransform> X_RL(model.links.size(), RigidTransform::Identity());
  for (const Joint& joint : model.joints) {
    const auto known = positions.find(joint.name);
    X_RL[static_cast<std::size_t>(joint.child)] =
        X_RL[static_cast<std::size_t>(joint.parent)] *
        joint.pose_at(known == positions.end() ? 0 : known->second);
  }
  return X_RL;
}

std::vector<RigidTransform> poses_in_world(const Platform& platform,
                                           const std::map<std::string, double>& positions) {
  std::vector<RigidTransform> X_WL = poses_in_root(platform.model, positions);
  const auto base = static_cast<std::size_t>(platform.model.link_index(platform.base));
  const RigidTransform X_WR = platform.X_WB * X_WL[base].inverse(Eigen::Isometry);
  for (RigidTransform& X : X_WL) X = X_WR * X;
  return X_WL;
}

std::vector<TriangleMesh> placed(const Platform& platform,
                                 const std::map<std::string, double>& positions, bool with_hand) {
  const RobotModel& model = platform.model;
  const std::vector<RigidTransform> X_WL = poses_in_world(platform, positions);
  std::vector<TriangleMesh> links_W;
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    const bool wanted = with_hand || !is_of_hand(model.links[l]);
    if (!wanted || model.links[l].shapes.empty()) continue;
    links_W.push_back(geometry::transformed(link_mesh(model.links[l]), X_WL[l]));
  }
  return links_W;
}

std::map<std::string, double> arm_positions(const Platform& platform,
                                            const Eigen::Ref<const Eigen::VectorXd>& arm) {
  const KinematicChain chain = platform.arm_chain();
  if (arm.size() != chain.size() || !arm.allFinite()) {
    throw std::invalid_argument(
        "placed_links(): the positions are not those of the platform's arm");
  }
  std::map<std::string, double> positions;
  for (int i = 0; i < chain.size(); ++i) {
    positions[chain.joints()[static_cast<std::size_t>(i)].name] = arm[i];
  }
  return positions;
}

void check_hand(const HandModel& hand, const Eigen::Ref<const Eigen::VectorXd>& all) {
  if (all.size() == static_cast<Eigen::Index>(hand.model.joints.size()) && all.allFinite()) return;
  throw std::invalid_argument("placed_links(): the positions are not those of the hand");
}

std::map<std::string, double> all_positions(const Platform& platform,
                                            const Eigen::Ref<const Eigen::VectorXd>& arm,
                                            const Eigen::Ref<const Eigen::VectorXd>& hand) {
  std::map<std::string, double> positions = arm_positions(platform, arm);
  const RobotModel& fingers = platform.hand.model;
  check_hand(platform.hand, hand);
  for (std::size_t i = 0; i < fingers.joints.size(); ++i) {
    positions[kHandPrefix + fingers.joints[i].name] = hand[static_cast<Eigen::Index>(i)];
  }
  return positions;
}

}  // namespace

bool is_of_hand(const Link& link) { return link.name.starts_with(kHandPrefix); }

std::vector<RigidTransform> placed_link_poses(const Platform& platform,
                                              const Eigen::Ref<const Eigen::VectorXd>& arm,
                                              const Eigen::Ref<const Eigen::VectorXd>& hand) {
  return poses_in_world(platform, all_positions(platform, arm, hand));
}

std::vector<TriangleMesh> placed_links(const Platform& platform,
                                       const Eigen::Ref<const Eigen::VectorXd>& arm,
                                       const Eigen::Ref<const Eigen::VectorXd>& hand) {
  return placed(platform, all_positions(platform, arm, hand), true);
}

std::vector<TriangleMesh> placed_arm_links(const Platform& platform,
                                           const Eigen::Ref<const Eigen::VectorXd>& arm) {
  return placed(platform, arm_positions(platform, arm), false);
}

std::vector<TriangleMesh> placed_hand_links(const HandModel& hand, const RigidTransform& X_WH,
                                            const Eigen::Ref<const Eigen::VectorXd>& all) {
  check_hand(hand, all);
  std::vector<RigidTransform> X_HL;
  hand.link_poses(all, X_HL);
  std::vector<TriangleMesh> links_W;
  for (std::size_t l = 0; l < hand.model.links.size(); ++l) {
    if (hand.model.links[l].shapes.empty()) continue;
    links_W.push_back(geometry::transformed(link_mesh(hand.model.links[l]), X_WH * X_HL[l]));
  }
  return links_W;
}

}  // namespace prehend::robot
