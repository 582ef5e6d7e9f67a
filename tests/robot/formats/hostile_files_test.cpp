// Files of strangers who mean harm: each is refused in words, or read; none takes more memory or
// time than a robot does.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/srdf.h"
#include "prehend/robot/mesh_shape.h"
#include "tests/robot/formats/hostile_files.h"
#include "tests/robot/formats/robot_files.h"
#include "tests/robot/formats/zip_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

class HostileFiles : public RobotFiles {
 protected:
  static bool has_mujoco() {
    return std::any_of(robot_formats().begin(), robot_formats().end(),
                       [](const auto& one) { return one->name() == "mjcf"; });
  }
  static std::vector<SmallFile> files(const std::string& link = "b") {
    std::vector<SmallFile> all = small_files(link);
    std::erase_if(all,
                  [](const SmallFile& one) { return one.name == "mjcf.xml" && !has_mujoco(); });
    return all;
  }
  /// As `prehend model check` and `convert` do: read, checked, mended, written in every format.
  /// @returns the words of a refusal; empty: it went through
  std::string went_through(const std::string& name, const std::string& text) {
    try {
      RobotDescription robot = read(name, text);
      check_model(robot, folder_);
      mend_model(robot, folder_);
      difference(robot, robot, 2);
      for (const auto& format : robot_formats()) {
        if (!format->can_write()) continue;
        LossReport loss;
        RobotDescription copy = robot;
        take_out_meshes(copy, folder_, "out", loss, format->taken_meshes());
        EXPECT_FALSE(format->write(copy, loss).empty());
      }
    } catch (const InputError& error) {
      EXPECT_FALSE(error.problem().empty());
      return error.what();
    }
    return {};
  }
  std::string findings_of(const RobotDescription& robot) {
    std::string all;
    for (const ModelFinding& one : check_model(robot, folder_)) {
      all += one.place + ": " + one.what + "\n";
    }
    return all;
  }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  all.reserve(text.size() * count);
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

TEST_F(HostileFiles, TheSmallOnesAreRobots) {
  for (const SmallFile& one : files()) {
    EXPECT_EQ(went_through(one.name, one.text), "") << one.name;
    EXPECT_GE(read(one.name, one.text).links.size(), 2U) << one.name;
  }
}

TEST_F(HostileFiles, EntitiesAreNotMadeOutOfOthersOrFiles) {
  file("secret", "SECRET");
  std::string bomb = "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>";
  for (char c = 'b'; c < 'k'; ++c) {
    bomb += std::string("<!ENTITY ") + c + " '" +
            repeated(std::string("&") + static_cast<char>(c - 1) + ";", 10) + "'>";
  }
  bomb += "]>";
  const std::string external =
      "<!DOCTYPE r [<!ENTITY j SYSTEM '" + (folder_ / "secret").string() + "'>]>";
  for (const std::string& declared : {bomb, external}) {
    for (const SmallFile& one : files("b&j;")) {
      if (one.name.ends_with("json")) continue;
      const std::string error = error_of(one.name, declared + one.text);
      if (!error.empty()) continue;
      for (const LinkDescription& link : read(one.name, declared + one.text).links) {
        EXPECT_LT(link.name.size(), 50U) << one.name;
        EXPECT_THAT(link.name, Not(HasSubstr("SECRET"))) << one.name;
      }
    }
  }
}

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

TEST_F(HostileFiles, NumbersBeyondMeasureAreRefusedInWords) {
  const bool had_log = fs::exists("MUJOCO_LOG.TXT");
  for (const char* number : {"nan", "inf", "-inf", "1e308", "-1e308", "1e99999", "0x10", "1e150",
                             "99999999999999999999999999", "1,5", ""}) {
    for (const SmallFile& one : files()) {
      for (const char* place : {"1 2 3", "0 0 1", "'1'", ">1<", "-1", "x='1'", "d0+1", "[1, 2, 3]",
                                "-1,", ">2<", "ixx='1'"}) {
        std::string to = number;
        if (std::strcmp(place, "1 2 3") == 0) to = std::string(number) + " 2 " + number;
        if (std::strcmp(place, "0 0 1") == 0) to = std::string("0 ") + number + " 1";
        if (std::strcmp(place, "'1'") == 0) to = "'" + to + "'";
        if (std::strcmp(place, "x='1'") == 0) to = "x='" + to + "'";
        if (std::strcmp(place, "ixx='1'") == 0) to = "ixx='" + to + "'";
        if (place[0] == '>') to = ">" + to + "<";
        if (std::strcmp(place, "d0+1") == 0) to = "d0+" + to;
        if (place[0] == '[') to = "[" + to + ", 2, " + to + "]";
        if (std::strcmp(place, "-1,") == 0) to += ",";
        const std::string text = replaced(one.text, place, to);
        if (text == one.text) continue;
        went_through(one.name, text);
        const std::string error = error_of(one.name, text);
        if (!error.empty()) continue;
        for (const JointDescription& joint : read(one.name, text).joints) {
          EXPECT_TRUE(joint.X_PJ.matrix().allFinite()) << one.name << ": " << text;
          EXPECT_TRUE(joint.axis_J.allFinite()) << one.name << ": " << text;
        }
      }
    }
  }
  EXPECT_EQ(fs::exists("MUJOCO_LOG.TXT"), had_log) << "MuJoCo's warnings are in the working folder";
  EXPECT_THAT(error_of("a.urdf", replaced(small_files()[0].text, "0 0 1", "0 1e308 1e308")),
              HasSubstr("axis"));
  EXPECT_THAT(error_of("a.urdf", replaced(small_files()[0].text, "1 2 3", "1e200 2 3")),
              HasSubstr("beyond all measure"));
}

// The library's regular expressions call themselves for each sign: a stack of some megabytes.
TEST_F(HostileFiles, VeryLongWordsAndNamesDoNotEndIt) {
  const std::string many(2000000, 'a'), digits(2000000, '1');
  for (const SmallFile& one : files(many)) {
    const std::string error = error_of(one.name, one.text);
    EXPECT_THAT(error, AnyOf("", HasSubstr(one.name))) << one.name;
  }
  const std::string graspit = small_files()[5].text;
  EXPECT_THAT(error_of("g.xml", replaced(graspit, "d0+1", "d0*" + digits)),
              HasSubstr("none of dN"));
  EXPECT_THAT(error_of("g.xml", replaced(graspit, "d0+1", "d99999999999")),
              HasSubstr("none of dN"));
  read("k.xml",
       replaced(small_files()[4].text, "type='hinge'", "type='hinge' mimic_pos='" + many + "'"));
  EXPECT_THAT(loss_.text(), HasSubstr("no linear formula"));
  file("long.iv", "#Inventor V2.1 ascii\nSeparator { File { name \"" + many + "\" } }\n");
  ShapeMeshes meshes(folder_);
  EXPECT_THROW(meshes.read("long.iv"), InputError);
}

TEST_F(HostileFiles, CutOffAnywhereTheyAreRefusedOrRead) {
  for (const SmallFile& one : files()) {
    for (std::size_t part = 0; part < 50; ++part) {
      const std::string text = one.text.substr(0, one.text.size() * part / 50);
      EXPECT_THAT(error_of(one.name, text), Not("")) << one.name << ": " << text;
    }
  }
}

TEST_F(HostileFiles, WhatIsNoFileOrNoTextIsRefused) {
  std::string garbage;
  std::uint32_t state = 1;
  for (int i = 0; i < 100000; ++i) {
    state = state * 1664525U + 1013904223U;
    garbage += static_cast<char>(state >> 24);
  }
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  for (const char* ending : {".urdf", ".sdf", ".xml", ".dae", ".zae", ".robot.json"}) {
    const std::string name = std::string("r") + ending;
    EXPECT_THAT(error_of(name, garbage), HasSubstr(name));
    EXPECT_THAT(error_of(name, ""), HasSubstr("empty"));
    EXPECT_THAT(error_of(name, std::string(1000, '\0')), HasSubstr(name));
    EXPECT_THAT(error_of(name, "PK\x03\x04" + garbage), HasSubstr(name));
    fs::remove(folder_ / name);
    fs::create_symlink(folder_ / "pipe", folder_ / name);
    EXPECT_THROW(read_robot(folder_ / name, loss_), InputError);
    fs::remove(folder_ / name);
    fs::create_directory(folder_ / name);
    EXPECT_THROW(read_robot(folder_ / name, loss_), InputError);
    fs::remove(folder_ / name);
  }
  // As a mesh, and as what a mesh and a model name.
  fs::create_symlink(folder_ / "pipe", folder_ / "pipe.stl");
  file("names.iv", "#Inventor V2.1 ascii\nSeparator { File { name \"pipe\" } }\n");
  ShapeMeshes meshes(folder_);
  for (const char* name : {"pipe.stl", "names.iv", "pipe", "."}) {
    EXPECT_THROW(meshes.read(name), InputError) << name;
  }
  if (!has_mujoco()) return;
  EXPECT_THAT(error_of("m.xml",
                       "<mujoco><asset><mesh name='m' file='pipe.stl'/></asset><worldbody>"
                       "<body><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"),
              HasSubstr("is no file"));
  EXPECT_THAT(error_of("m.xml", "<mujoco><include file='pipe'/></mujoco>"),
              HasSubstr("is no file"));
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
  EXPECT_THAT(error_of_zip(repeated("<a>", 4000000)), HasSubstr("more than a million"));
  EXPECT_THAT(error_of_zip(std::string(70 << 20, 'a')), HasSubstr("larger than 64 MiB"));
  pack(folder_ / "inner.zae", {{"manifest.xml", manifest}});
  std::ifstream stream(folder_ / "inner.zae", std::ios::binary);
  EXPECT_THAT(error_of_zip({std::istreambuf_iterator<char>(stream), {}}),
              HasSubstr("no well-formed XML"));
}

TEST_F(HostileFiles, PathsAreNeverCommandsAndPackagesAreNotLeft) {
  const std::string paths[] = {"$(touch touched)",
                               "`touch touched`",
                               "; touch touched",
                               "| touch touched",
                               "a\nb",
                               "../../../../etc/passwd",
                               "/etc/passwd",
                               "file:///etc/passwd",
                               "%2e%2e/etc/passwd",
                               "\\\\host\\share",
                               "http://host/a.stl",
                               "a.stl?<script>",
                               "file://",
                               "package://",
                               "package://p",
                               std::string(5000, 'a')};
  for (const std::string& path : paths) {
    RobotDescription robot;
    robot.name = "<script>alert(1)</script>";
    Shape mesh;
    mesh.kind = Shape::Kind::kMesh;
    mesh.mesh = path;
    robot.links = {{"\" onload=\"alert(1)", {}, {mesh}, {mesh}}};
    EXPECT_FALSE(findings_of(robot).empty()) << path;
    LossReport loss;
    EXPECT_TRUE(take_out_meshes(robot, folder_, "out", loss, TakenMeshes::kAll).empty()) << path;
    EXPECT_THAT(loss.text(), HasSubstr("mesh")) << path;
    for (const char* format : {"urdf", "sdf", "json"}) {
      const RobotDescription again = written_and_read(robot, format);
      EXPECT_EQ(again.links[0].visuals[0].mesh, path) << format;
      EXPECT_EQ(again.links[0].name, robot.links[0].name) << format;
      EXPECT_EQ(again.name, robot.name) << format;
    }
  }
  EXPECT_FALSE(fs::exists("touched") || fs::exists(folder_ / "touched"));
  file("p/a.stl", "");
  file("b.stl", "");
  for (const char* name :
       {"package://p/../b.stl", "package://p/../../b.stl", "package://p/x/../../b.stl",
        "package://../b.stl", "package://./b.stl", "package:////etc/passwd", "model://p/../b.stl",
        "package://p//etc/passwd"}) {
    EXPECT_THROW(find_mesh_file(name, folder_), InputError) << name;
    const RobotDescription robot =
        read("r.urdf", std::string("<robot name='r'><link name='a'><collision><geometry><mesh "
                                   "filename='") +
                           name + "'/></geometry></collision></link></robot>");
    EXPECT_THAT(findings_of(robot), HasSubstr("leaves its package")) << name;
  }
  EXPECT_EQ(find_mesh_file("package://p/x/../a.stl", folder_), folder_ / "p/x/../a.stl");
  // What is written beside the robot's file stays there, whatever it is called.
  RobotDescription robot;
  Shape shape;
  shape.kind = Shape::Kind::kMesh;
  shape.mesh = "../../../tmp/$(x)/..";
  shape.surface = std::make_shared<const geometry::TriangleMesh>(geometry::make_box({1, 1, 1}));
  robot.links = {{"a", {}, {shape}, {}}};
  LossReport loss;
  const auto meshes = take_out_meshes(robot, folder_, "../out", loss);
  ASSERT_EQ(meshes.size(), 1U);
  EXPECT_THAT(meshes[0].file.string(), Not(HasSubstr("..")));
}

TEST_F(HostileFiles, UnknownNamespacesAndUnitsAreSaid) {
  EXPECT_THAT(error_of("n.urdf", "<x:robot xmlns:x='urn:other'><x:link name='a'/></x:robot>"),
              HasSubstr("<x:robot>"));
  read("n.urdf", "<robot name='r' xmlns:x='urn:other'><link name='a' x:b='1'/><x:soul/></robot>");
  EXPECT_THAT(loss_.text(), HasSubstr("x:soul"));
  EXPECT_THAT(loss_.text(), HasSubstr("@x:b"));
  EXPECT_THAT(error_of("u.xml", replaced(small_files()[3].text, "units='m'", "units='inch'")),
              HasSubstr("'inch' is not known"));
  for (const char* unit : {"0", "-1", "nan", "inf", "x"}) {
    EXPECT_THAT(error_of("u.dae", replaced(small_files()[6].text, "<library_k",
                                           std::string("<asset><unit meter='") + unit +
                                               "'/></asset><library_k")),
                HasSubstr("u.dae:1"))
        << unit;
  }
}

/// A ball of about `count` triangles, as binary STL; rough by `noise` of its radius.
void write_ball(const fs::path& file, int count, double radius, double noise) {
  const int rows = static_cast<int>(std::sqrt(count / 2.0));
  const auto at = [&](int i, int j) {
    const double polar = std::numbers::pi * i / rows,
                 round = 2 * std::numbers::pi * (j % rows) / rows;
    const auto hash = static_cast<std::uint32_t>(i * 7919 + (j % rows) * 104729) * 2654435761U;
    const double r = radius * (1 + noise * (hash / 4294967296.0 - 0.5));
    return Eigen::Vector3f(static_cast<float>(r * std::sin(polar) * std::cos(round)),
                           static_cast<float>(r * std::sin(polar) * std::sin(round)),
                           static_cast<float>(r * std::cos(polar)));
  };
  std::string bytes(80, 'x');
  const auto add = [&](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  const std::uint32_t triangles = static_cast<std::uint32_t>(2 * rows * rows);
  add(&triangles, 4);
  const auto triangle = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                            const Eigen::Vector3f& c) {
    const Eigen::Vector3f none = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f* p : {&none, &a, &b, &c}) add(p->data(), 12);
    bytes.append(2, '\0');
  };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < rows; ++j) {
      triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  std::ofstream(file, std::ios::binary) << bytes;
}

/// Two links of that mesh, which are not joined to one another, 1.5 radii apart.
std::string two_of(const std::string& mesh) {
  const std::string shape =
      "<collision><geometry><mesh filename='" + mesh + "'/></geometry></collision></link>";
  return "<robot name='r'><link name='a'>" + shape + "<link name='m'/><link name='b'>" +
         "<inertial><mass value='1'/><inertia ixx='0' ixy='0' ixz='0' iyy='0' iyz='0' izz='0'/>"
         "</inertial>" +
         shape +
         "<joint name='j' type='continuous'><parent link='a'/><child link='m'/></joint>"
         "<joint name='k' type='continuous'><parent link='m'/><child link='b'/><origin xyz='0.15 0 "
         "0'/></joint></robot>";
}

TEST_F(HostileFiles, MeshesOfTwoMillionTrianglesAreThinnedWithAWord) {
  write_ball(folder_ / "ball.stl", 2000000, 0.1, 0);
  RobotDescription robot = read("two.urdf", two_of("ball.stl"));
  const std::string found = findings_of(robot);
  EXPECT_THAT(found, HasSubstr("link 'a' and link 'b': overlap by 49."));  // of 50 mm
  EXPECT_THAT(found, HasSubstr("triangles, was thinned to"));
  // Small ones are compared as they are.
  write_ball(folder_ / "small.stl", 20000, 0.1, 0);
  robot = read("two.urdf", two_of("small.stl"));
  EXPECT_THAT(findings_of(robot), Not(HasSubstr("thinned")));
  EXPECT_THAT(findings_of(robot), HasSubstr("link 'a' and link 'b': overlap by 49."));
  const auto mended = mend_model(robot, folder_);
  ASSERT_EQ(mended.size(), 1U);
  EXPECT_NEAR(robot.link("b")->inertial->inertia(0, 0), 0.4 * 0.1 * 0.1, 4e-5);
}

// All of a thousand balls at one place: half a million pairs of hulls of 500 corners.
TEST_F(HostileFiles, ShapesAtOnePlaceAreLookedAtInPart) {
  std::string text = "<robot name='r'><link name='root'/>";
  for (int i = 0; i < 1000; ++i) {
    const std::string n = std::to_string(i);
    text +=
        "<link name='m" + n + "'/><link name='l" + n +
        "'><collision><geometry><sphere radius='1'/></geometry></collision></link><joint name='i" +
        n + "' type='continuous'><parent link='root'/><child link='m" + n +
        "'/></joint><joint name='j" + n + "' type='continuous'><parent link='m" + n +
        "'/><child link='l" + n + "'/></joint>";
  }
  const RobotDescription robot = read("balls.urdf", text + "</robot>");
  EXPECT_THAT(findings_of(robot), HasSubstr("more pairs near one another than are looked at"));
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
