// What is found wrong with a robot, and mended.

#include <gmock/gmock.h>

#include "prehend/robot/formats/model_check.h"
#include "tests/robot/formats/arm_urdf.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using testing::Contains;
using testing::HasSubstr;
using ModelCheck = RobotFiles;

TEST_F(ModelCheck, CheckNamesWhatNoBodyHas) {
  std::string text = kUrdfArm;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("izz=\"0.01\"", "izz=\"0.09\"");
  replace("lower=\"-2\" upper=\"1.5\"", "lower=\"2\" upper=\"-1.5\"");
  replace("<sphere radius=\"0.05\"/>", "<mesh filename=\"gone.stl\" scale=\"1 -1 1\"/>");
  replace("effort=\"30\"", "effort=\"0\"");
  const RobotDescription arm = read("arm.urdf", text);
  std::string all;
  for (const ModelFinding& one : check_model(arm, folder_))
    all += one.place + ": " + one.what + "\n";
  EXPECT_THAT(all, HasSubstr("link 'upper': has principal inertias"));
  EXPECT_THAT(all, HasSubstr("joint 'shoulder': has limits that are exchanged"));
  EXPECT_THAT(all, HasSubstr("link 'lower': names a mesh that is not there"));
  EXPECT_THAT(all, HasSubstr("link 'lower': mirrors the mesh"));
  EXPECT_THAT(all, HasSubstr("joint 'shoulder': has no effort"));
  EXPECT_THAT(all, HasSubstr("link 'lower': moves and has no inertia"));
  RobotDescription mended = arm;
  EXPECT_THAT(mend_model(mended, "."), Contains(HasSubstr("limits exchanged")));
  EXPECT_EQ(*mended.joint("shoulder")->lower, -1.5);
}

TEST_F(ModelCheck, InertiaIsComparedWithTheShape) {
  // A box of 2 kg, as its shape has it, and with millimetres taken for metres.
  const auto findings_of = [&](double factor) {
    RobotDescription robot = read("arm.urdf", kUrdfArm);
    Inertial& inertial = *robot.links[1].inertial;
    const Eigen::Vector3d s = robot.links[1].collisions[0].size;
    inertial.inertia = factor * inertial.mass / 12 *
                       Eigen::Vector3d(s.y() * s.y() + s.z() * s.z(), s.x() * s.x() + s.z() * s.z(),
                                       s.x() * s.x() + s.y() * s.y())
                           .asDiagonal();
    std::string all;
    for (const ModelFinding& one : check_model(robot, folder_)) {
      if (one.place == "link 'upper'") all += one.what;
    }
    return all;
  };
  EXPECT_EQ(findings_of(1), "");
  EXPECT_THAT(findings_of(1e6), HasSubstr("no shape that far"));
  EXPECT_THAT(findings_of(1e-9), HasSubstr("million times less"));
}

}  // namespace
}  // namespace prehend::robot::formats
