// What an SRDF says beside a URDF.

#include "prehend/robot/formats/srdf.h"

#include <gmock/gmock.h>

#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

class Srdf : public RobotFiles {
 protected:
  RobotDescription read_beside(const std::string& srdf) {
    file("arm.srdf", "<robot name='arm'>" + srdf + "</robot>");
    return read("arm.urdf",
                R"(<robot name="arm"><link name="base"/><link name="upper"/><link name="palm"/>
      <link name="finger"/><link name="thumb"/>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/></joint>
      <joint name="wrist" type="continuous"><parent link="upper"/><child link="palm"/></joint>
      <joint name="curl" type="continuous"><parent link="palm"/><child link="finger"/></joint>
      <joint name="spread" type="fixed"><parent link="palm"/><child link="thumb"/></joint></robot>)");
  }
};

const std::string kAll = R"(
  <group name="arm"><chain base_link="base" tip_link="palm"/></group>
  <group name="fingers"><link name="finger"/><joint name="spread"/></group>
  <group name="hand"><group name="fingers"/></group>
  <group name="alone"><joint name="wrist"/></group>
  <group_state name="open" group="hand"><joint name="curl" value="0.5"/><joint name="gone" value="1"/></group_state>
  <end_effector name="grip" parent_link="palm" group="hand" parent_group="arm"/>
  <virtual_joint name="world" type="fixed" parent_frame="world" child_link="base"/>
  <passive_joint name="wrist"/>
  <disable_collisions link1="base" link2="palm" reason="Never"/>
  <disable_collisions link1="base" link2="tail"/>)";

TEST_F(Srdf, IsReadWithItsUrdf) {
  const RobotDescription arm = read_beside(kAll);
  ASSERT_EQ(arm.manipulators.size(), 1U);
  EXPECT_EQ(arm.manipulators[0].base, "base");
  EXPECT_EQ(arm.manipulators[0].tip, "palm");
  ASSERT_EQ(arm.manipulators[0].closing.size(), 1U);  // the thumb's is fixed
  EXPECT_EQ(arm.manipulators[0].closing[0].first, "curl");
  ASSERT_EQ(arm.postures.size(), 1U);
  EXPECT_EQ(arm.postures[0].group, "hand");
  EXPECT_EQ(arm.postures[0].positions.at("curl"), 0.5);
  EXPECT_TRUE(arm.joint("wrist")->passive);
  EXPECT_FALSE(arm.joint("curl")->passive);
  ASSERT_EQ(arm.disabled_collisions.size(), 1U);
  EXPECT_THAT(loss_.text(), AllOf(HasSubstr("arm.srdf"), HasSubstr("virtual_joint"),
                                  HasSubstr("its links are not there"),
                                  HasSubstr("group: groups are kept where an end effector")));
}

TEST_F(Srdf, ComesBackAsItWas) {
  const RobotDescription arm = read_beside(kAll);
  EXPECT_TRUE(needs_srdf(arm));
  LossReport loss;
  file("again.srdf", write_srdf(arm, loss));
  EXPECT_TRUE(loss.lossless()) << loss.text();
  RobotDescription again = arm;
  take_out_srdf(again);
  EXPECT_FALSE(needs_srdf(again));
  file("again.urdf", format_named("urdf").write(again, loss));
  EXPECT_TRUE(loss.entries().empty() || loss.text().find("SRDF") == std::string::npos);
  again = read_robot(folder_ / "again.urdf", loss);
  ASSERT_EQ(again.manipulators.size(), 1U);
  EXPECT_EQ(again.manipulators[0].name, "grip");
  EXPECT_EQ(again.manipulators[0].base, "base");
  EXPECT_EQ(again.manipulators[0].closing, arm.manipulators[0].closing);
  EXPECT_EQ(again.postures[0].positions, arm.postures[0].positions);
  EXPECT_TRUE(again.joint("wrist")->passive);
  EXPECT_EQ(again.disabled_collisions, arm.disabled_collisions);
}

TEST_F(Srdf, WritersSayWhatOthersDoNotRead) {
  RobotDescription arm = read_beside(kAll);
  arm.manipulators[0].closing[0].second = 1;
  arm.manipulators[0].X_TipTool.translation().z() = 0.1;
  for (const char* format : {"urdf", "sdf"}) {
    LossReport its;
    format_named(format).write(arm, its);
    EXPECT_TRUE(its.lossless());
    EXPECT_THAT(its.text(), AllOf(HasSubstr("kept in prehend's extension"), HasSubstr("1 posture"),
                                  HasSubstr("1 joint (passive)"), HasSubstr("1 manipulator")))
        << format;
  }
  // What the SRDF says of it stands there, the rest in the URDF.
  LossReport loss;
  file("again.srdf", write_srdf(arm, loss));
  RobotDescription again = arm;
  take_out_srdf(again);
  EXPECT_EQ(again.manipulators.size(), 1U);
  EXPECT_TRUE(again.postures.empty());
  file("again.urdf", format_named("urdf").write(again, loss));
  EXPECT_TRUE(loss.lossless());
  again = read_robot(folder_ / "again.urdf", loss);
  ASSERT_EQ(again.manipulators.size(), 1U);
  EXPECT_EQ(again.manipulators[0].closing, arm.manipulators[0].closing);
  EXPECT_EQ(again.manipulators[0].X_TipTool.translation().z(), 0.1);
}

TEST_F(Srdf, BadFilesAreRefusedInWords) {
  const auto error_of_srdf = [&](const std::string& srdf) {
    try {
      read_beside(srdf);
    } catch (const geometry::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(error_of_srdf("<group"), HasSubstr("no well-formed XML"));
  EXPECT_THAT(error_of_srdf("<disable_collisions link1='base'/>"), HasSubstr("has no link2"));
  EXPECT_THAT(error_of_srdf("<group_state name='a'><joint name='curl' value='nan'/></group_state>"),
              HasSubstr("'nan' is no number"));
  EXPECT_THAT(error_of_srdf("<group name='a'><group name='a'/></group>"
                            "<end_effector name='e' group='a' parent_link='palm'/>"),
              HasSubstr("ring"));
}

}  // namespace
}  // namespace prehend::robot::formats
