#include "nodes/report/drawn_robot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "prehend/geometry/errors.h"
#include "prehend/report/robot_meshes.h"

namespace prehend::nodes {
namespace {

using geometry::TriangleMesh;
using report::ColoredMesh;

constexpr geometry::Rgb kPadColor{60, 60, 65};
constexpr const char* kHandPrefix = "hand_";

TriangleMesh box_at(const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  return geometry::transformed(geometry::make_box(size),
                               geometry::make_transform(Eigen::Quaterniond::Identity(), center));
}

class DrawnGripper : public DrawnRobot {
 public:
  explicit DrawnGripper(robot::GripperModel gripper) : gripper_(std::move(gripper)) {}

  std::vector<std::string> pads() const override { return {"left", "right"}; }

  std::vector<ColoredMesh> hand_at(const msgs::Grasp& grasp) const override {
    const auto X_WG = convert::from_message(grasp.x_wg());
    const double opening = grasp.predicted().opening();
    return {{geometry::transformed(body(opening), X_WG), kHandColor},
            {geometry::transformed(pads_at(opening), X_WG), kPadColor}};
  }

  std::vector<ColoredMesh> arm_at(const msgs::Grasp& /*grasp*/) const override { return {}; }

  std::string closing_text(const msgs::Grasp& grasp) const override {
    return fmt::format("opening at contact {:.1f} mm, force {:.1f} N",
                       1000 * grasp.predicted().opening(), grasp.grasp_force());
  }

 private:
  // Fingers and housing in the gripper's frame G.
  TriangleMesh body(double opening) const {
    const Eigen::Vector3d& finger = gripper_.finger_size;
    const double finger_y = (opening + finger.y()) / 2 + gripper_.pad.thickness;
    const double finger_z = gripper_.tip_z() - finger.z() / 2;
    return geometry::concatenated(
        {box_at(finger, {0, finger_y, finger_z}), box_at(finger, {0, -finger_y, finger_z}),
         box_at(gripper_.housing_size,
                {0, 0, gripper_.housing_front_z() - gripper_.housing_size.z() / 2})});
  }

  TriangleMesh pads_at(double opening) const {
    const auto& pad = gripper_.pad;
    const Eigen::Vector3d size(pad.width(), pad.thickness, pad.length());
    const double y = (opening + pad.thickness) / 2;
    return geometry::concatenated({box_at(size, {0, y, 0}), box_at(size, {0, -y, 0})});
  }

  robot::GripperModel gripper_;
};

class DrawnPlatform : public DrawnRobot {
 public:
  explicit DrawnPlatform(robot::Platform platform) : platform_(std::move(platform)) {}

  std::vector<std::string> pads() const override {
    std::vector<std::string> names;
    for (const robot::HandPad& pad : platform_.hand.pads) names.push_back(pad.name);
    return names;
  }

  std::vector<ColoredMesh> hand_at(const msgs::Grasp& grasp) const override {
    const robot::HandModel& hand = platform_.hand;
    const auto X_WH = convert::from_message(grasp.x_wg()) *
                      (hand.X_HP * hand.preshape(grasp.preshape()).X_PG).inverse();
    const Eigen::VectorXd closed = closed_hand(grasp);
    return {{geometry::transformed(report::robot_mesh(hand.model, closed), X_WH), kHandColor},
            {geometry::transformed(cells_at(closed), X_WH), kPadColor}};
  }

  std::vector<ColoredMesh> arm_at(const msgs::Grasp& grasp) const override {
    const msgs::ArmSegment* approach = nullptr;
    for (const msgs::ArmSegment& segment : grasp.arm()) {
      const bool leads_to_it =
          segment.kind() == msgs::ArmSegment::REACH || segment.kind() == msgs::ArmSegment::APPROACH;
      if (leads_to_it) approach = &segment;
    }
    if (!approach || approach->trajectory().points_size() == 0) return {};
    // The links of the arm alone: the hand is drawn closed.
    robot::RobotModel arm = platform_.model;
    for (robot::Link& link : arm.links) {
      if (link.name.starts_with(kHandPrefix)) link.shapes.clear();
    }
    Eigen::VectorXd positions = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(arm.joints.size()));
    const msgs::JointTrajectory& trajectory = approach->trajectory();
    const auto& end = trajectory.points(trajectory.points_size() - 1);
    for (int i = 0; i < std::min(trajectory.joint_name_size(), end.position_size()); ++i) {
      positions[arm.joint_index(trajectory.joint_name(i))] = end.position(i);
    }
    return {{geometry::transformed(report::robot_mesh(arm, positions), platform_.X_WB), kArmColor}};
  }

  std::string closing_text(const msgs::Grasp& grasp) const override {
    return fmt::format("preshape {}, {} predicted contacts", grasp.preshape(),
                       grasp.contacts_size());
  }

 private:
  // The pads' cells on the hand in its frame H, as squares a little smaller than they are, over the
  // links.
  TriangleMesh cells_at(const Eigen::VectorXd& all) const {
    constexpr double kShare = 0.8, kOver = 2e-4;  // of the side; m
    const robot::HandModel& hand = platform_.hand;
    std::vector<geometry::RigidTransform> X_HL;
    hand.link_poses(all, X_HL);
    TriangleMesh mesh;
    for (const robot::HandPad& pad : hand.pads) {
      const geometry::RigidTransform X_HP = X_HL[static_cast<std::size_t>(pad.link)] * pad.X_LP;
      for (std::size_t i = 0; i < pad.layout->size(); ++i) {
        if (pad.layout->area(i) == 0) continue;
        const double half = 0.5 * kShare * std::sqrt(pad.layout->area(i));
        const Eigen::Vector3d u = half * pad.layout->first_tangent(i),
                              v = half * pad.layout->second_tangent(i),
                              p = pad.layout->position(i) + kOver * pad.layout->normal(i);
        const int first = static_cast<int>(mesh.vertices.size());
        for (const Eigen::Vector3d& corner :
             std::initializer_list<Eigen::Vector3d>{-u - v, u - v, u + v, -u + v}) {
          mesh.vertices.push_back(X_HP * (p + corner));
        }
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.triangles.emplace_back(first, first + 2, first + 3);
      }
    }
    return mesh;
  }

  // Positions of all joints of the hand where its fingers touch.
  Eigen::VectorXd closed_hand(const msgs::Grasp& grasp) const {
    const robot::HandModel& hand = platform_.hand;
    Eigen::VectorXd motors = hand.preshape(grasp.preshape()).open;
    for (int i = 0; i < std::min(grasp.hand_joint_name_size(), grasp.closed_position_size()); ++i) {
      const std::string& name = grasp.hand_joint_name(i);
      const std::string own =
          name.starts_with(kHandPrefix) ? name.substr(std::string(kHandPrefix).size()) : name;
      motors[hand.actuated_index(own)] = grasp.closed_position(i);
    }
    return hand.all_positions(motors);
  }

  robot::Platform platform_;
};

}  // namespace

std::unique_ptr<DrawnRobot> make_drawn(robot::GripperModel gripper) {
  return std::make_unique<DrawnGripper>(std::move(gripper));
}

std::unique_ptr<DrawnRobot> make_drawn(robot::Platform platform) {
  return std::make_unique<DrawnPlatform>(std::move(platform));
}

}  // namespace prehend::nodes
