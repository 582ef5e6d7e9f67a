// OpenRAVE's own XML.

#include <algorithm>
#include <numbers>

#include "prehend/robot/formats/model_check.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;
using OpenRaveFiles = RobotFiles;

const std::string kKinBody = R"(<KinBody name="arm">
  <Body name="base" type="static"><Geom type="cylinder"><radius>0.1</radius><height>0.2</height></Geom></Body>
  <Body name="Upper"><offsetfrom>base</offsetfrom><Translation>0 0 0.3</Translation><rotationaxis>0 0 1 90</rotationaxis>
    <mass type="box"><total>3</total><extents>0.1 0.1 0.2</extents></mass></Body>
  <Body name="lower"><offsetfrom>Upper</offsetfrom><translation>0.2 0 0</translation>
    <geom type="box"><extents>0.1 0.2 0.3</extents></geom></Body>
  <Joint name="J1" type="hinge"><Body>base</Body><Body>Upper</Body><offsetfrom>Upper</offsetfrom><axis>0 1 0</axis>
    <anchor>0 0 0.05</anchor><lostop>-90</lostop><histop>45</histop><maxvel>2</maxvel></Joint>
  <Joint name="J2" type="slider" mimic_pos="J1/4+0.02"><Body>Upper</Body><Body>lower</Body><offsetfrom>lower</offsetfrom>
    <axis>0 0 1</axis><limits>0.5 0</limits></Joint>
</KinBody>)";

TEST_F(OpenRaveFiles, OpenRaveJointsHaveAnAnchorAndOldStopsTurnTheOtherWay) {
  const RobotDescription arm = read("arm.kinbody.xml", kKinBody);
  EXPECT_NEAR(*arm.joint("J1")->lower, -std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(*arm.joint("J2")->upper, 0.5);
  EXPECT_NEAR(arm.link("Upper")->inertial->inertia(2, 2), 3.0 / 3 * 0.02, 1e-12);
  EXPECT_EQ(arm.link("lower")->collisions[0].size.y(), 0.4);
  // The cylinder stands along y.
  EXPECT_TRUE((arm.link("base")->collisions[0].X_LS.linear() * Eigen::Vector3d::UnitZ())
                  .isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  const double q = 0.4;
  RigidTransform upper = RigidTransform::Identity();
  upper.translate(Eigen::Vector3d(0, 0, 0.3));
  upper.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  RigidTransform about = RigidTransform::Identity();
  about.translate(Eigen::Vector3d(0, 0, 0.05));
  about.rotate(Eigen::AngleAxisd(-q, Eigen::Vector3d::UnitY()));
  about.translate(Eigen::Vector3d(0, 0, -0.05));
  const auto poses = link_poses(arm, {{"J1", q}});
  EXPECT_TRUE(poses.at("Upper").isApprox(upper * about, 1e-12));
  RigidTransform lower = RigidTransform::Identity();
  lower.translate(Eigen::Vector3d(0.2, 0, q / 4 + 0.02));
  EXPECT_TRUE(poses.at("lower").isApprox(upper * about * lower, 1e-12));
  for (const char* format : {"urdf", "sdf"}) {
    const ModelDifference found = difference(arm, written_and_read(arm, format));
    EXPECT_LT(std::max(found.place, found.turn), 1e-9) << format;
  }
}

}  // namespace
}  // namespace prehend::robot::formats
