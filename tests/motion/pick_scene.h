#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "prehend/geometry/rotation_between.h"
#include "prehend/motion/pick_motion.h"
#include "tests/motion/fcl_oracle.h"
#include "tests/motion/shelves.h"

namespace prehend::motion {

/// An arm of config/robots with a simple parallel gripper, a table at height 0 and a box to pick.
struct PickScene {
  robot::RobotModel model;
  robot::KinematicChain chain;
  CollisionWorld world;
  FclOracle oracle;     // the arm and its hand, against all but the object
  FclOracle at_object;  // the arm without its hand, against the object
  FclOracle hand;       // the hand, against the object
  PickTask task;
  Eigen::Vector3d size{0.05, 0.05, 0.16};  // of the object [m]

  /// @param object where the middle of its bottom stands.
  PickScene(const std::string& arm, const Eigen::Vector3d& object)
      : model(with_gripper(arm)),
        chain(model, "base_link", "grip"),
        oracle(model, chain),
        at_object(model, chain),
        hand(model, chain) {
    const int last = chain.size() - 1;
    std::erase_if(at_object.parts, [last](const auto& part) { return part.joint == last; });
    std::erase_if(hand.parts, [last](const auto& part) { return part.joint != last; });
    // The arm stands in a hole: its base is not tested, but its first links may pass low.
    add("table", at(0, 0, -0.05), {4, 4, 0.1});
    task.object.X_BO = at(object.x(), object.y(), object.z() + size.z() / 2);
    task.object.cover_O = cover_convex_pieces({geometry::make_box(size)});
    world.add_box("object", task.object.X_BO, size);
    at_object.add_box(task.object.X_BO, size);
    hand.add_box(task.object.X_BO, size);
    task.start = chain.middle();
  }

  void add(const std::string& name, const geometry::RigidTransform& X, const Eigen::Vector3d& box) {
    world.add_box(name, X, box);
    oracle.add_box(X, box);
  }
  RobotInWorld in_world() const {
    return {chain, make_robot_spheres(model, "base_link", "grip", 0.05), world, 0.005};
  }
  robot::InverseKinematics inverse() const {
    return robot::InverseKinematics(chain, {.elbow_angles = 12});
  }

  /// With the hand's z axis along `approach`, its fingers closing across `roll` [rad], the tip
  /// `above` [m] over the object's middle.
  void grasp(const Eigen::Vector3d& approach, double roll, double above) {
    const Eigen::Vector3d z = approach.normalized();
    PickGrasp grasp;
    grasp.X_BT.linear() = (geometry::rotation_between(Eigen::Vector3d::UnitZ(), z) *
                           Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
                              .toRotationMatrix();
    grasp.X_BT.translation() = task.object.X_BO * Eigen::Vector3d(0, 0, above);
    grasp.X_BT.makeAffine();
    grasp.approach_direction_B = z;
    grasp.pregrasp_distance = 0.15;
    task.grasps.push_back(grasp);
  }
  void grasps_from_above() {
    for (int i = 0; i < 8; ++i) grasp(-Eigen::Vector3d::UnitZ(), i * std::numbers::pi / 4, 0.06);
  }
  void grasps_from_the_side(double turn) {
    for (int i = 0; i < 8; ++i) {
      const double a = turn + 0.3 * (i - 4);
      grasp({std::cos(a), std::sin(a), 0}, std::numbers::pi / 2, 0.04);
    }
  }

  static robot::RobotModel with_gripper(const std::string& arm) {
    const bool is_kr5 = arm == "kr5";
    robot::RobotModel model = robot::read_urdf(is_kr5 ? "config/robots/kr5_sixx_r850.urdf"
                                                      : "config/robots/pa10_7c.urdf");
    const int flange = model.link_index("tool0");
    const robot::Joint& fixed = model.joints[static_cast<std::size_t>(*model.joint_above(flange))];
    auto& shapes = model.links[static_cast<std::size_t>(fixed.parent)].shapes;
    const auto box = [&](double y, double z, const Eigen::Vector3d& size) {
      robot::CollisionShape shape;
      shape.X_LS = fixed.X_PJ * at(0, y, z);
      shape.size = size;
      shapes.push_back(shape);
    };
    box(0, 0.04, {0.08, 0.12, 0.08});
    box(0.045, 0.13, {0.02, 0.02, 0.1});
    box(-0.045, 0.13, {0.02, 0.02, 0.1});
    robot::Joint joint;
    joint.name = "grip_joint";
    joint.parent = flange;
    joint.child = static_cast<int>(model.links.size());
    joint.X_PJ = at(0, 0, 0.16);
    model.links.push_back({"grip", 0, {}});
    model.joints.push_back(joint);
    return model;
  }

  /// What is wrong with a motion, looked at every 5 mrad by FCL; empty when nothing is.
  std::string problem(const PickMotion& motion) const {
    robot::Positions last = task.start;
    for (const PickSegment& segment : motion.segments) {
      const std::string name = to_string(segment.kind);
      if ((segment.waypoints.front() - last).norm() > 1e-9) return name + " starts apart";
      last = segment.waypoints.back();
      for (const robot::Positions& q : dense(segment)) {
        if (!chain.within_limits(q)) return name + ": " + chain.limit_problem(q);
        if (std::string text = touch(motion, segment, q); !text.empty()) {
          return name + ": " + text;
        }
      }
    }
    return {};
  }

 private:
  static std::vector<robot::Positions> dense(const PickSegment& segment) {
    std::vector<robot::Positions> result{segment.waypoints.front()};
    for (std::size_t i = 1; i < segment.waypoints.size(); ++i) {
      const robot::Positions way = segment.waypoints[i] - segment.waypoints[i - 1];
      const int steps = 1 + static_cast<int>(way.norm() / 0.005);
      for (int k = 1; k <= steps; ++k) {
        result.push_back(segment.waypoints[i - 1] + way * (static_cast<double>(k) / steps));
      }
    }
    if (segment.trajectory) {
      for (int i = 0; i <= 300; ++i) {
        result.push_back(segment.trajectory->at(segment.trajectory->duration() * i / 300).position);
      }
    }
    return result;
  }

  std::string touch(const PickMotion& motion, const PickSegment& segment,
                    const robot::Positions& q) const {
    if (oracle.collides(chain, q)) return "the arm touches something";
    if (segment.holds) {
      // A millimetre smaller: it stands on the table.
      FclOracle held = oracle;
      const geometry::RigidTransform X_TO =
          task.grasps[static_cast<std::size_t>(motion.grasp)].X_BT.inverse() * task.object.X_BO;
      held.parts = {{chain.size() - 1, chain.X_JT() * X_TO,
                     std::make_shared<fcl::Box<double>>(size - Eigen::Vector3d::Constant(2e-3))}};
      return held.collides(chain, q) ? "what is held touches something" : "";
    }
    if (segment.kind == SegmentKind::kRetreat) return {};
    if (at_object.collides(chain, q)) return "the arm touches the object";
    if (segment.kind == SegmentKind::kReach && hand.collides(chain, q))
      return "the hand touches the object";
    return {};
  }
};

}  // namespace prehend::motion
