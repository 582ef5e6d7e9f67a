// Files that are refused, and sizes that are not.

#include <gmock/gmock.h>

#include <chrono>

#include "prehend/geometry/errors.h"
#include "tests/robot/formats/robot_files.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;
using testing::AllOf;
using testing::HasSubstr;
using RefusedFiles = RobotFiles;

TEST_F(RefusedFiles, BadFilesAreRefusedInWords) {
  EXPECT_THAT(error_of("a.urdf", "<robot><link"), HasSubstr("a.urdf:1 is no well-formed XML"));
  EXPECT_THAT(error_of("a.urdf", ""), HasSubstr("empty"));
  EXPECT_THAT(error_of("a.xml", "<page/>"), AllOf(HasSubstr("<page>"), HasSubstr("urdf")));
  const auto with_joint = [](const std::string& joint) {
    return "<robot name='r'><link name='a'/><link name='b'/>" + joint + "</robot>";
  };
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='hinge'><parent link='a'/>"
                                            "<child link='b'/></joint>")),
              HasSubstr("'hinge'"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><parent link='a'/>"
                                            "<child link='c'/></joint>")),
              HasSubstr("'c'"));
  EXPECT_THAT(error_of("a.urdf", with_joint("")), HasSubstr("both have no joint above"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><origin xyz='1 2 x'/>"
                                            "<parent link='a'/><child link='b'/></joint>")),
              HasSubstr("'x' is no number"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><origin xyz='1 nan 2'/>"
                                            "<parent link='a'/><child link='b'/></joint>")),
              HasSubstr("nan"));
  EXPECT_THAT(error_of("a.urdf", with_joint("<joint name='j' type='fixed'><parent link='a'/>"
                                            "<child link='b'/></joint><joint name='k' type='fixed'>"
                                            "<parent link='b'/><child link='a'/></joint>")),
              HasSubstr("ring"));
  EXPECT_THAT(error_of("a.urdf", "<robot xmlns:xacro='x'><xacro:arm/></robot>"),
              HasSubstr("xacro"));
  EXPECT_THROW(format_named("urfd"), InputError);
  EXPECT_THROW(format_for("robot.txt"), InputError);
}

TEST_F(RefusedFiles, EntitiesDoNotGrow) {
  std::string bomb = "<?xml version='1.0'?><!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>";
  for (char c = 'b'; c < 'k'; ++c) {
    bomb += std::string("<!ENTITY ") + c + " '";
    for (int i = 0; i < 10; ++i) bomb += std::string("&") + static_cast<char>(c - 1) + ";";
    bomb += "'>";
  }
  bomb += "]><robot name='&j;'><link name='a'/></robot>";
  const auto begin = std::chrono::steady_clock::now();
  try {
    EXPECT_LT(read("bomb.urdf", bomb).name.size(), 100U);
  } catch (const InputError&) {
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  std::string deep = "<robot name='r'>";
  for (int i = 0; i < 100000; ++i) deep += "<link>";
  EXPECT_FALSE(error_of("deep.urdf", deep).empty());
}

TEST_F(RefusedFiles, ManyLinksStayQuick) {
  std::string text = "<robot name='chain'><link name='l0'/>";
  for (int i = 1; i < 2000; ++i) {
    const std::string n = std::to_string(i), before = std::to_string(i - 1);
    text += "<link name='l" + n + "'/><joint name='j" + n + "' type='continuous'><parent link='l" +
            before + "'/><child link='l" + n + "'/></joint>";
  }
  EXPECT_EQ(read("chain.urdf", text + "</robot>").links.size(), 2000U);
}

}  // namespace
}  // namespace prehend::robot::formats
