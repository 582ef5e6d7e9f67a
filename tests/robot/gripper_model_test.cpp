#include "prehend/robot/gripper_model.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot {
namespace {

class GripperFile : public testing::Test {
 protected:
  GripperFile()
      : path_(std::filesystem::temp_directory_path() /
              ("prehend_gripper_" + std::to_string(getpid()) + ".yaml")) {}
  ~GripperFile() override { std::filesystem::remove(path_); }

  GripperModel read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_gripper_model(path_);
  }
  std::string error_of(const std::string& text) {
    try {
      read(text);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path path_;
};

TEST_F(GripperFile, Pg70IsReadAsShipped) {
  const GripperModel model = read_gripper_model("config/robots/pg70_dsa.yaml");
  EXPECT_EQ(model.name, "pg70_dsa");
  EXPECT_EQ(model.pad.rows * model.pad.columns, 84);
  EXPECT_DOUBLE_EQ(model.max_opening, 0.069);
  EXPECT_NEAR(model.pad.length(), 0.0476, 1e-12);
  EXPECT_NEAR(model.tip_z(), 0.0258, 1e-12);
  EXPECT_NEAR(model.housing_front_z(), -0.0842, 1e-12);
  EXPECT_DOUBLE_EQ(model.pad.law.viscous_friction, 0.1);
}

TEST_F(GripperFile, MissingKeysKeepTheDefaults) {
  const GripperModel model = read("name: other\npad: {law: {damping: 4}}\n");
  EXPECT_EQ(model.name, "other");
  EXPECT_DOUBLE_EQ(model.max_speed, GripperModel{}.max_speed);
  EXPECT_DOUBLE_EQ(model.pad.law.damping, 4);
}

TEST_F(GripperFile, UnknownKeyNamesLineAndNearestKey) {
  const std::string error = error_of("name: x\nmax_opning: 0.07\n");
  EXPECT_NE(error.find(path_.string() + ":2:"), std::string::npos) << error;
  EXPECT_NE(error.find("'max_opening'"), std::string::npos) << error;
  EXPECT_NE(error_of("pad: {law: {sigma: 1}}\n").find("pad.law"), std::string::npos);
}

TEST_F(GripperFile, BadValuesAreRefusedByName) {
  EXPECT_NE(error_of("max_speed: fast\n").find("max_speed"), std::string::npos);
  EXPECT_NE(error_of("max_speed: .nan\n").find("max_speed"), std::string::npos);
  EXPECT_NE(error_of("jaw_mass: 0\n").find("jaw_mass"), std::string::npos);
  EXPECT_NE(error_of("finger_size: [1, 2]\n").find("finger_size"), std::string::npos);
  EXPECT_NE(error_of("pad: {rows: -3}\n").find("rows"), std::string::npos);
  EXPECT_NE(error_of("pad: {law: {stiffness: -1}}\n").find("stiffness"), std::string::npos);
  EXPECT_NE(error_of("pad: 3\n").find("map"), std::string::npos);
}

TEST_F(GripperFile, ForeignFilesAreRefused) {
  EXPECT_THROW(read_gripper_model("config/robots/none.yaml"), geometry::InputError);
  EXPECT_THROW(read_gripper_model("config"), geometry::InputError);
  EXPECT_NE(error_of("").find("map"), std::string::npos);
  EXPECT_NE(error_of("a: [1, 2\nb: 3").find("YAML"), std::string::npos);
  EXPECT_FALSE(error_of(std::string("\x00\xff\xfe PK\x03\x04", 8)).empty());
}

TEST_F(GripperFile, DifferencesNameEveryFieldWithBothValues) {
  const GripperModel shipped = read_gripper_model("config/robots/pg70_dsa.yaml");
  EXPECT_TRUE(differences(shipped, shipped).empty());
  GripperModel other = shipped;
  other.max_opening = 0.12;
  EXPECT_EQ(differences(shipped, other), std::vector<std::string>{"max_opening: 0.069 and 0.12"});
  other = shipped;
  other.name = "wide";
  other.finger_size.z() = 0.2;
  other.pad.rows = 10;
  other.pad.law.bristle_law = contact::BristleLaw::kLuGre;
  const auto all = differences(shipped, other);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0], "name: pg70_dsa and wide");
  EXPECT_NE(all[1].find("finger_size"), std::string::npos) << all[1];
  EXPECT_EQ(all[2], "pad.rows: 14 and 10");
  EXPECT_NE(all[3].find("pad.law.bristle_law"), std::string::npos) << all[3];
}

TEST_F(GripperFile, TextIsReadAsItsFile) {
  std::ifstream file("config/robots/pg70_dsa.yaml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(differences(parse_gripper_model(text, "a robot's word"),
                          read_gripper_model("config/robots/pg70_dsa.yaml"))
                  .empty());
  try {
    parse_gripper_model("name: x\nmax_opning: 0.07\n", "a robot's word");
    ADD_FAILURE() << "taken";
  } catch (const geometry::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("a robot's word:2:"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace prehend::robot
