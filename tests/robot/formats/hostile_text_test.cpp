// Files of strangers who mean harm, by what is written in them: entities, numbers, names, what is
// cut off or no text at all. Each is refused in words, or read.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstdint>
#include <cstring>
#include <filesystem>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "tests/robot/formats/hostile_files.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

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

}  // namespace
}  // namespace prehend::robot::formats
