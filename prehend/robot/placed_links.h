#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/platform.h"

namespace prehend::robot {

/// The collision shapes of all links of a platform where they are, in the world; links without any
/// are left out.
/// @param arm of arm_chain()'s joints [rad or m]. @param hand of all joints of the hand's model.
/// @throws std::invalid_argument for another number of either, or what is not finite.
std::vector<geometry::TriangleMesh> placed_links(const Platform& platform,
                                                 const Eigen::Ref<const Eigen::VectorXd>& arm,
                                                 const Eigen::Ref<const Eigen::VectorXd>& hand);

/// Where all links of a platform's model are, in its order; arguments and errors as placed_links().
std::vector<geometry::RigidTransform> placed_link_poses(
    const Platform& platform, const Eigen::Ref<const Eigen::VectorXd>& arm,
    const Eigen::Ref<const Eigen::VectorXd>& hand);

/// Whether a link of a platform's model is its hand's.
bool is_of_hand(const Link& link);

/// The same as placed_links(), of the arm alone, without its hand.
std::vector<geometry::TriangleMesh> placed_arm_links(const Platform& platform,
                                                     const Eigen::Ref<const Eigen::VectorXd>& arm);

/// The same of a hand alone whose root is at X_WH. @param all of its joints, of the hand's model.
std::vector<geometry::TriangleMesh> placed_hand_links(const HandModel& hand,
                                                      const geometry::RigidTransform& X_WH,
                                                      const Eigen::Ref<const Eigen::VectorXd>& all);

}  // namespace prehend::robot
