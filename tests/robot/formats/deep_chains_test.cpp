// Links one above the other, in formats that have each within the element of the one above.

#include <gmock/gmock.h>

#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
using testing::AllOf;
using testing::HasSubstr;

class DeepChains : public RobotFiles {
 protected:
  /// @param root of MJCF's own name, or another
  static RobotDescription chain(int links, const std::string& root = "l0", bool is_star = false) {
    RobotDescription robot;
    robot.name = "rope";
    Inertial ball{1, geometry::RigidTransform::Identity(), Eigen::Matrix3d::Identity()};
    for (int i = 0; i < links; ++i) {
      robot.links.push_back({i == 0 ? root : "l" + std::to_string(i), ball, {}, {}});
      if (i == 0) robot.links.back().inertial.reset();
      if (i == 0) continue;
      JointDescription joint;
      joint.name = "j" + std::to_string(i);
      joint.kind = JointDescription::Kind::kRevolute;
      joint.parent = robot.links[is_star ? 0 : static_cast<std::size_t>(i) - 1].name;
      joint.child = robot.links.back().name;
      joint.X_PJ.translation().x() = 0.1;
      robot.joints.push_back(joint);
    }
    return robot;
  }
  static std::string error_of_writing(const RobotDescription& robot, const std::string& format) {
    try {
      LossReport unused;
      format_named(format).write(robot, unused);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
  /// All that is written is read again, all that would not be is refused.
  void expect_most(int links, const std::string& format, const std::string& root) {
    const RobotDescription longest = chain(links, root);
    LossReport loss;
    const RobotDescription again =
        read("again" + format_named(format).ending(), format_named(format).write(longest, loss));
    EXPECT_TRUE(loss.lossless()) << loss.text();
    EXPECT_EQ(again.links.size(), longest.links.size()) << format << ", " << root;
    EXPECT_THAT(error_of_writing(chain(links + 1, root), format),
                AllOf(HasSubstr("Link 'l" + std::to_string(links) + "' has " +
                                std::to_string(links) + " links above it"),
                      HasSubstr("Write URDF, SDF or .robot.json")))
        << format << ", " << root;
  }
};

TEST_F(DeepChains, AreWrittenAsFarAsTheyAreRead) {
  expect_most(47, "collada", "l0");
  for (const std::string& format : written_formats()) {
    if (format != "mjcf") continue;
    expect_most(96, format, "l0");
    expect_most(97, format, "world");
  }
}

/// Ten thousand links one above the other, which recursion and indentation would not end with.
TEST_F(DeepChains, OfTenThousandAreRefusedOrWritten) {
  const RobotDescription robot = chain(10000);
  for (const std::string& format : written_formats()) {
    if (format == "collada" || format == "zae" || format == "mjcf") {
      EXPECT_THAT(error_of_writing(robot, format), HasSubstr(" links above it")) << format;
      continue;
    }
    EXPECT_EQ(written_and_read(robot, format).links.size(), 10000U) << format;
  }
}

TEST_F(DeepChains, ManyBesideOneAnotherAreWritten) {
  const RobotDescription robot = chain(10000, "l0", true), fewer = chain(2000, "l0", true);
  for (const std::string& format : written_formats()) {
    EXPECT_EQ(written_and_read(fewer, format).links.size(), 2000U) << format;
    if (format == "urdf" || format == "sdf" || format == "json") {
      EXPECT_EQ(written_and_read(robot, format).links.size(), 10000U) << format;
    } else if (format == "mjcf") {
      EXPECT_THAT(error_of_writing(robot, format), HasSubstr("more than 2000 links"));
    } else {  // they are more elements than are read, which the report says
      LossReport loss;
      format_named(format).write(robot, loss);
      EXPECT_THAT(loss.text(), HasSubstr("more than a million elements")) << format;
    }
  }
}

}  // namespace
}  // namespace prehend::robot::formats
