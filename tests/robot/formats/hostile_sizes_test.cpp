// Files of strangers who mean harm, by how large they make themselves: links, nesting, files in
// rings, archives. None takes more memory or time than a robot does.

#include <gmock/gmock.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "tests/robot/formats/hostile_files.h"
#include "tests/robot/formats/zip_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using testing::AnyOf;
using testing::HasSubstr;

TEST_F(HostileFiles, AMillionLinksAreRefused) {
  constexpr int kMany = 1000000;
  const auto many = [](const std::function<std::string(const std::string&)>& one) {
    std::string all;
    for (int i = 0; i < kMany; ++i) all += one(std::to_string(i));
    return all;
  };
  const auto link = [](const std::string& n) { return "<link name='" + n + "'/>"; };
  const auto is_refused = HasSubstr("more than");
  EXPECT_THAT(error_of("a.urdf", "<robot name='r'>" + many(link) + "</robot>"), is_refused);
  EXPECT_THAT(
      error_of("a.sdf", "<sdf version='1.7'><model name='m'>" + many(link) + "</model></sdf>"),
      is_refused);
  EXPECT_THAT(error_of("a.xml", "<KinBody>" + many([](const std::string& n) {
                                  return "<Body name='" + n + "'/>";
                                }) + "</KinBody>"),
              is_refused);
  EXPECT_THAT(error_of("a.xml", "<Robot RootNode='0'>" + many([](const std::string& n) {
                                  return "<RobotNode name='" + n + "'/>";
                                }) + "</Robot>"),
              is_refused);
  EXPECT_THAT(error_of("a.xml", "<robot><palm>p</palm><chain>" +
                                    repeated("<link dynamicJointType='Fixed'>a</link>", kMany) +
                                    "</chain></robot>"),
              is_refused);
  EXPECT_THAT(
      error_of("a.robot.json",
               R"({"prehend_robot": 1, "name": "r", "links": [)" + many([](const std::string& n) {
                 return R"({"name": ")" + n + "\"}, ";
               }) + R"({"name": "z"}]})"),
      is_refused);
  if (!has_mujoco()) return;
  EXPECT_THAT(error_of("a.xml", "<mujoco><worldbody>" + repeated("<body/>", kMany) +
                                    "</worldbody></mujoco>"),
              is_refused);
}

TEST_F(HostileFiles, TenThousandLinksInARowOrAStarAreReadAndOneMoreIsNot) {
  for (const bool is_row : {true, false}) {
    for (const std::size_t count : {kMostLinks, kMostLinks + 1}) {
      std::string text = "<robot name='r'><link name='0'/>";
      for (std::size_t i = 1; i < count; ++i) {
        const std::string n = std::to_string(i), above = is_row ? std::to_string(i - 1) : "0";
        text += "<link name='" + n + "'/><joint name='j" + n +
                "' type='continuous'><parent link='" + above + "'/><child link='" + n +
                "'/></joint>";
      }
      const std::string error = error_of("many.urdf", text + "</robot>");
      if (count > kMostLinks) {
        EXPECT_THAT(error, HasSubstr("has more than 10000 links or joints"));
        continue;
      }
      ASSERT_EQ(error, "");
      const RobotDescription robot = read("many.urdf", text + "</robot>");
      EXPECT_EQ(check_model(robot, folder_).size(), 3 * (count - 1));
      EXPECT_LT(difference(robot, robot, 2).place, 1e-12);
    }
  }
}

// Each followed one more: the check took the cube of their number.
TEST_F(HostileFiles, LongRowsOfFollowersAreRefused) {
  std::string text = "<robot name='r'><link name='0'/>";
  for (int i = 1; i < 5000; ++i) {
    const std::string n = std::to_string(i);
    text += "<link name='" + n + "'/><joint name='j" + n +
            "' type='continuous'><parent link='0'/><child link='" + n + "'/><mimic joint='j" +
            std::to_string(i + 1) + "'/></joint>";
  }
  text +=
      "<link name='z'/><joint name='j5000' type='continuous'><parent link='0'/><child link='z'/>"
      "</joint></robot>";
  const RobotDescription robot = read("row.urdf", text);
  EXPECT_THAT(findings_of(robot), HasSubstr("over too many joints"));
  EXPECT_THROW(link_poses(robot, {}), InputError);
}

// Made of 64 MiB of these, values were gigabytes.
TEST_F(HostileFiles, WhatGrowsWhenItIsParsedIsRefused) {
  const std::size_t many = 4000000;
  EXPECT_THAT(
      error_of("a.urdf", "<robot name='r'><link name='a'/>" + repeated("<b/>", many) + "</robot>"),
      HasSubstr("more than a million elements"));
  std::string attributes;
  for (int i = 0; i < 100000; ++i) attributes += " a" + std::to_string(i) + "='<'";
  EXPECT_THAT(error_of("a.urdf", "<robot name='r'" + attributes + "><link name='a'/></robot>"),
              HasSubstr("more than 1000 attributes"));
  EXPECT_THAT(error_of("a.robot.json", R"({"prehend_robot": 1, "name": "r", "links": [)" +
                                           repeated("[],", many) + "[]]}"),
              HasSubstr("more than two million values"));
  std::string keys;
  for (int i = 0; i < 100000; ++i) keys += "\"" + std::to_string(i) + "\": 0, ";
  EXPECT_THAT(error_of("a.robot.json", "{" + keys + R"("prehend_robot": 1})"),
              HasSubstr("more than 10000 keys"));
  // What is no element is not counted.
  EXPECT_EQ(error_of("a.urdf", "<robot name='r'><!-- " + repeated("<b/>", 1100000) +
                                   " --><link name='a'/></robot>"),
            "");
  std::ofstream(folder_ / "large.urdf").close();
  fs::resize_file(folder_ / "large.urdf", std::uintmax_t{1} << 40);
  EXPECT_THROW(read_robot(folder_ / "large.urdf", loss_), InputError);
}

TEST_F(HostileFiles, DeepNestingIsRefused) {
  const std::size_t deep = 100000;
  for (const char* root : {"robot", "sdf", "mujoco", "KinBody", "Robot", "COLLADA"}) {
    EXPECT_THAT(error_of("deep.xml", std::string("<") + root + ">" + repeated("<a>", deep)),
                HasSubstr("deep.xml"))
        << root;
  }
  EXPECT_THAT(error_of("deep.robot.json", repeated("{\"a\":", deep)), HasSubstr("deeper than 32"));
  EXPECT_THAT(error_of("deep.robot.json", "{\"a\":" + repeated("[", deep)),
              HasSubstr("deeper than 32"));
}

TEST_F(HostileFiles, FilesThatNameThemselvesAreRefused) {
  EXPECT_THAT(error_of("self.kinbody.xml",
                       "<KinBody file='self.kinbody.xml' name='r'><Body "
                       "name='a'/></KinBody>"),
              HasSubstr("ring"));
  EXPECT_THAT(error_of("self.xml",
                       "<Robot RootNode='a'><RobotNode name='a'><ChildFromRobot><File>"
                       "self.xml</File></ChildFromRobot></RobotNode></Robot>"),
              HasSubstr("ring"));
  // Each names the next twice: two to the fifteenth.
  for (int i = 0; i < 15; ++i) {
    const std::string next = "n" + std::to_string(i + 1) + ".xml";
    file("n" + std::to_string(i) + ".xml", "<KinBody><KinBody file='" + next + "' prefix='a'/>" +
                                               "<KinBody file='" + next +
                                               "' prefix='b'/></KinBody>");
  }
  file("n15.xml", "<KinBody/>");
  try {
    read_robot(folder_ / "n0.xml", loss_);
    ADD_FAILURE() << "read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("10,000 files"));
  }
  file("ring.iv", "#Inventor V2.1 ascii\nSeparator { File { name \"ring.iv\" } }\n");
  ShapeMeshes meshes(folder_);
  EXPECT_THROW(meshes.read("ring.iv"), InputError);
  if (!has_mujoco()) return;
  EXPECT_THAT(error_of("self.xml", "<mujoco><include file='self.xml'/></mujoco>"),
              HasSubstr("includes itself"));
}

TEST_F(HostileFiles, RingsOfLinksAreRefused) {
  const auto ring = [](const std::string& first, const std::string& second) {
    return "<robot name='r'><link name='0'/><link name='1'/><link name='2'/><joint name='j' "
           "type='fixed'><parent link='" +
           first + "'/><child link='" + second +
           "'/></joint><joint name='k' type='fixed'><parent " + "link='" + second +
           "'/><child link='" + first + "'/></joint></robot>";
  };
  EXPECT_THAT(error_of("ring.urdf", ring("1", "2")), HasSubstr("ring"));
  EXPECT_THAT(error_of("ring.urdf", ring("1", "1")), HasSubstr("two joints above"));
  EXPECT_THAT(error_of("ring.sdf",
                       "<sdf version='1.7'><model name='m'><link name='a'><pose "
                       "relative_to='b'/></link><link name='b'><pose relative_to='a'/>"
                       "</link><joint name='j' type='fixed'><parent>a</parent><child>b"
                       "</child></joint></model></sdf>"),
              HasSubstr("ring"));
}

// Two to the thirtieth, by 30 groups that each name the next twice.
TEST_F(HostileFiles, GroupsOfSrdfDoNotGrow) {
  std::string srdf = "<robot name='r'><end_effector name='e' group='g0' parent_link='a'/>";
  for (int i = 0; i < 30; ++i) {
    const std::string next = "<group name='g" + std::to_string(i + 1) + "'/>";
    srdf += "<group name='g" + std::to_string(i) + "'>" + next + next + "</group>";
  }
  file("r.srdf", srdf + "<group name='g30'><link name='b'/></group></robot>");
  EXPECT_THAT(error_of("r.urdf", small_files()[0].text),
              AnyOf(HasSubstr("grow without end"), HasSubstr("more than")));
  std::string pairs = "<robot name='r'>";
  for (int i = 0; i < 300000; ++i) pairs += "<disable_collisions link1='a' link2='b'/>";
  file("r.srdf", pairs + "</robot>");
  EXPECT_EQ(read("r.urdf", small_files()[0].text).disabled_collisions.size(), 300000U);
}

TEST_F(HostileFiles, ZipsDoNotGrow) {
  const std::string manifest = "<dae_root>./r.dae</dae_root>";
  const auto error_of_zip = [&](const std::string& text) {
    pack(folder_ / "r.zae", {{"manifest.xml", manifest}, {"r.dae", text}});
    try {
      read_robot(folder_ / "r.zae", loss_);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(error_of_zip(small_files()[6].text), "");
  EXPECT_THAT(error_of_zip(repeated("<a/>", 4000000)), HasSubstr("more than a million"));
  EXPECT_THAT(error_of_zip(std::string(70 << 20, 'a')), HasSubstr("larger than 64 MiB"));
  pack(folder_ / "inner.zae", {{"manifest.xml", manifest}});
  std::ifstream stream(folder_ / "inner.zae", std::ios::binary);
  EXPECT_THAT(error_of_zip({std::istreambuf_iterator<char>(stream), {}}),
              HasSubstr("no well-formed XML"));
}

// Each reference looked through the whole document again, where that had no ids.
TEST_F(HostileFiles, ManyReferencesToNothingAreReadInOnePass) {
  const std::string body =
      "<kinematics_model name='r'><technique_common><link sid='a' name='a'/>"
      "</technique_common></kinematics_model></library_kinematics_models>";
  const std::string extra =
      "<extra type='attach_sensor' name='s'><technique profile='OpenRAVE'><instance_sensor "
      "url='#s'/>"
      "<frame_origin link='k/a'/></technique></extra>";
  const RobotDescription robot = read(
      "r.dae", "<COLLADA version='1.5.0'><library_kinematics_models>" + body +
                   "<library_articulated_systems><articulated_system>" + repeated(extra, 50000) +
                   "</articulated_system></library_articulated_systems></COLLADA>");
  EXPECT_EQ(robot.links.size(), 1U);
}

TEST_F(HostileFiles, ModelsOfMuJoCoDoNotGrow) {
  if (!has_mujoco()) GTEST_SKIP() << "built without MuJoCo";
  const auto in_body = [](const std::string& what) {
    return "<mujoco><worldbody><body>" + what + "</body></worldbody></mujoco>";
  };
  EXPECT_THAT(error_of("m.xml", in_body("<composite type='grid' count='1000 1000 1'/>")),
              HasSubstr("more than 2000 bodies"));
  EXPECT_THAT(error_of("m.xml", "<mujoco><size nuser_body='1000000000'/></mujoco>"),
              HasSubstr("nuser_body"));
  EXPECT_THAT(error_of("m.xml",
                       "<mujoco><asset><hfield name='h' nrow='100000' ncol='100000' "
                       "size='1 1 1 1'/></asset></mujoco>"),
              HasSubstr("field"));
  EXPECT_THAT(error_of("m.xml",
                       "<mujoco><asset><texture name='t' type='2d' builtin='flat' "
                       "width='100000' height='100000'/></asset></mujoco>"),
              HasSubstr("texture"));
}

}  // namespace
}  // namespace prehend::robot::formats
