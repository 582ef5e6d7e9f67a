#pragma once

#include <memory>
#include <string>
#include <vector>

#include "msgs/grasp.pb.h"
#include "prehend/report/pictures.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

inline constexpr geometry::Rgb kHandColor{150, 155, 165};
inline constexpr geometry::Rgb kArmColor{205, 140, 95};

/// What the page draws of the robot, whichever it is.
class DrawnRobot {
 public:
  virtual ~DrawnRobot() = default;

  /// Names of its pads: the topics /tactile/NAME.
  virtual std::vector<std::string> pads() const = 0;
  /// The hand, closed at the grasp, in the world. @throws geometry::InputError for a grasp that is
  /// not this robot's.
  virtual std::vector<report::ColoredMesh> hand_at(const msgs::Grasp& grasp) const = 0;
  /// What carries it, where it stands then; nothing when the grasp does not say.
  virtual std::vector<report::ColoredMesh> arm_at(const msgs::Grasp& grasp) const = 0;
  /// How the hand is closed, in words.
  virtual std::string closing_text(const msgs::Grasp& grasp) const = 0;
};

/// A parallel gripper as boxes; its carrier is not drawn.
std::unique_ptr<DrawnRobot> make_drawn(robot::GripperModel gripper);
/// An arm with a hand, by the collision shapes of their links.
std::unique_ptr<DrawnRobot> make_drawn(robot::Platform platform);

}  // namespace prehend::nodes
