// SDF: poses in frames, axes of old versions.

#include <numbers>

#include "prehend/robot/formats/model_check.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using SdfFiles = RobotFiles;

TEST_F(SdfFiles, SdfPosesAreGivenInFrames) {
  const RobotDescription robot = read("r.sdf", R"(<sdf version="1.7"><model name="m">
    <frame name="stand"><pose>0 0 1 0 0 0</pose></frame>
    <link name="a"><pose relative_to="stand">0 0 0.5 0 0 0</pose></link>
    <link name="b"><pose relative_to="a">1 0 0 0 0 1.5707963267948966</pose></link>
    <joint name="b" type="revolute"><pose>0 -0.5 0 0 0 0</pose><parent>a</parent><child>b</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
    </model></sdf>)");
  const auto poses = link_poses(robot, {});
  EXPECT_TRUE(poses.at("b").translation().isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  // It turns about a place beside its origin: -0.5 along the link's y is +0.5 along x of a's.
  const auto turned = link_poses(robot, {{"b", std::numbers::pi / 2}});
  EXPECT_TRUE(turned.at("b").translation().isApprox(Eigen::Vector3d(1.5, -0.5, 0), 1e-12))
      << turned.at("b").translation().transpose();
  for (const char* format : {"urdf", "sdf"}) {
    const RobotDescription again = written_and_read(robot, format);
    EXPECT_LT(difference(robot, again).place, 1e-9) << format;
  }
}

TEST_F(SdfFiles, SdfAxesUntilFourAreTheModels) {
  const auto axis_of = [&](const char* version) {
    const RobotDescription robot =
        read("r.sdf", std::string("<sdf version='") + version +
                          "'><model name='m'><link name='a'/><link name='b'><pose>0 0 0 0 0 "
                          "1.5707963267948966</pose></link><joint name='j' type='revolute'>"
                          "<parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis></joint>"
                          "</model></sdf>");
    return robot.joints[0].axis_J;
  };
  EXPECT_TRUE(axis_of("1.4").isApprox(Eigen::Vector3d(0, -1, 0), 1e-12));
  EXPECT_TRUE(axis_of("1.5").isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
}

}  // namespace
}  // namespace prehend::robot::formats
