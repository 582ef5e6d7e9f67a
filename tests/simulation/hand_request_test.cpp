#include "prehend/simulation/hand_request.h"

#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/robot/platform.h"

namespace prehend::simulation {
namespace {

std::string refusal_of(const RobotWorld& world, const HandRequest& request) {
  try {
    check_hand_request(world, request);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(HandRequestTest, NamesAreThePlatformsOrTheHandsAndTheOthersStay) {
  const RobotWorld world(robot::read_platform("config/robots/kr5_sdh.yaml"), Scene());
  const std::vector<std::string>& names = world.motor_names();
  const std::string own = names[2].substr(std::string("hand_").size());
  const NamedHandCommand named =
      check_hand_request(world, {{names[4], own}, {0.2, 0.1}, 0.5, true, {0.3, 0.4}});
  EXPECT_EQ(named.motors, (std::vector<int>{4, 2}));
  Eigen::VectorXd position = world.hand().targets(), effort = world.hand().most_efforts();
  position[4] = 0.2;
  position[2] = 0.1;
  effort[4] = 0.3;
  effort[2] = 0.4;
  EXPECT_EQ(named.command.position, position);
  EXPECT_EQ(named.command.effort, effort);
  EXPECT_EQ(named.command.speed, 0.5);
  EXPECT_TRUE(named.command.until_contact);
}

TEST(HandRequestTest, RefusesInWords) {
  const RobotWorld world(robot::read_platform("config/robots/kr5_sdh.yaml"), Scene());
  const std::string& motor = world.motor_names()[1];
  EXPECT_EQ(refusal_of(world, {}), "the goal names no joint");
  EXPECT_EQ(refusal_of(world, {{motor}, {}, 0.3, false, {}}), "0 positions for 1 joints");
  EXPECT_EQ(refusal_of(world, {{motor}, {0.1}, 0.3, false, {1, 1}}), "2 efforts for 1 joints");
  EXPECT_EQ(refusal_of(world, {{motor, motor}, {0.1, 0.1}, 0.3, false, {}}),
            "joint '" + motor + "' is named twice");
  const std::string typo = motor + "x";
  const std::string unknown = refusal_of(world, {{typo}, {0.1}, 0.3, false, {}});
  EXPECT_EQ(unknown.find("the hand has no motor '" + typo + "'"), 0u) << unknown;
  EXPECT_NE(unknown.find(motor, typo.size()), std::string::npos) << "the nearest: " << unknown;
}

}  // namespace
}  // namespace prehend::simulation
