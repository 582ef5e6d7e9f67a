#include "prehend/robot/placed_links.h"

#include <map>
#include <stdexcept>
#include <string>

#include "prehend/robot/link_mesh.h"

namespace prehend::robot {

std::vector<geometry::TriangleMesh> placed_links(const Platform& platform,
                                                 const Eigen::Ref<const Eigen::VectorXd>& arm,
                                                 const Eigen::Ref<const Eigen::VectorXd>& hand) {
  const KinematicChain chain = platform.arm_chain();
  const RobotModel& fingers = platform.hand.model;
  if (arm.size() != chain.size() ||
      hand.size() != static_cast<Eigen::Index>(fingers.joints.size()) || !arm.allFinite() ||
      !hand.allFinite()) {
    throw std::invalid_argument("placed_links(): the positions are not those of the platform");
  }
  std::map<std::string, double> positions;
  for (int i = 0; i < chain.size(); ++i) {
    positions[chain.joints()[static_cast<std::size_t>(i)].name] = arm[i];
  }
  for (std::size_t i = 0; i < fingers.joints.size(); ++i) {
    positions["hand_" + fingers.joints[i].name] = hand[static_cast<Eigen::Index>(i)];
  }
  const RobotModel& model = platform.model;
  std::vector<geometry::RigidTransform> X_RL(model.links.size(),
                                             geometry::RigidTransform::Identity());
  for (const Joint& joint : model.joints) {
    const auto known = positions.find(joint.name);
    X_RL[static_cast<std::size_t>(joint.child)] =
        X_RL[static_cast<std::size_t>(joint.parent)] *
        joint.pose_at(known == positions.end() ? 0 : known->second);
  }
  const auto base = static_cast<std::size_t>(model.link_index(platform.base));
  const geometry::RigidTransform X_WR = platform.X_WB * X_RL[base].inverse(Eigen::Isometry);
  std::vector<geometry::TriangleMesh> placed;
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    if (model.links[l].shapes.empty()) continue;
    placed.push_back(geometry::transformed(link_mesh(model.links[l]), X_WR * X_RL[l]));
  }
  return placed;
}

}  // namespace prehend::robot
