// Platforms and hands that cannot work are refused when they are read, in words.

#include <functional>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "tests/robot/as_meshes.h"
#include "tests/robot/robot_file.h"
#include "tests/robot/without_pads.h"

namespace prehend::robot {
namespace {

using ::testing::HasSubstr;

/// What a stranger got wrong: in `file` of config/robots the first match of `pattern` is replaced.
struct Mistake {
  const char* name;
  const char* file;
  const char* pattern;
  const char* replacement;
  std::vector<const char*> said;  // all of it is in the one error
  const char* hand = "sdh2.yaml";
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

class RefusedPlatform : public RobotFile, public testing::WithParamInterface<Mistake> {
 protected:
  void edit(const std::string& file, const std::string& pattern, const std::string& replacement) {
    const std::string before = text_of(folder_ / file);
    const std::string after = std::regex_replace(before, std::regex(pattern), replacement,
                                                 std::regex_constants::format_first_only);
    ASSERT_NE(before, after) << file << " has no " << pattern;
    std::ofstream(folder_ / file) << after;
  }
};

TEST_P(RefusedPlatform, InWordsWhenItIsRead) {
  const Mistake& mistake = GetParam();
  edit("kr5_sdh.yaml", "sdh2.yaml\n", std::string(mistake.hand) + " \n");
  read_platform(folder_ / "kr5_sdh.yaml");  // it is right before
  edit(mistake.file, mistake.pattern, mistake.replacement);
  const std::string error = error_of([&] { read_platform(folder_ / "kr5_sdh.yaml"); });
  EXPECT_NE(error, "") << "accepted";
  EXPECT_THAT(error, HasSubstr("kr5_sdh.yaml"));
  EXPECT_THAT(error, HasSubstr(mistake.file));
  for (const char* part : mistake.said) EXPECT_THAT(error, HasSubstr(part));
}

constexpr const char* kArm = "kr5_sixx_r850.urdf";
constexpr const char* kSdh = "schunk_sdh2.urdf";
constexpr const char* kPg70 = "pg70.urdf";
constexpr const char* kPlatform = "kr5_sdh.yaml";
constexpr const char* kHand = "sdh2.yaml";

INSTANTIATE_TEST_SUITE_P(
    Mistakes, RefusedPlatform,
    testing::Values(
        Mistake{"NoArm", kPlatform, "arm: [^\n]*", "", {"platform.arm is missing"}},
        Mistake{"NoHand", kPlatform, "hand: [^\n]*", "", {"platform.hand is missing"}},
        Mistake{"ACameraSomewhere",
                kPlatform,
                "mount:",
                "camera: {xyz: [0, 0]}\nmount:",
                {"platform.camera.xyz"}},
        Mistake{"NoSuchArm",
                kPlatform,
                "arm: kr5_sixx",
                "arm: kr5_six",
                {"kr5_sdh.yaml:3", "kr5_six_r850.urdf' cannot be read"}},
        Mistake{"NoSuchHand",
                kPlatform,
                "hand: sdh2",
                "hand: sdh3",
                {"kr5_sdh.yaml:6", "sdh3.yaml does not exist"}},
        Mistake{"AGripperAsHand",
                kPlatform,
                "hand: sdh2",
                "hand: pg70_dsa",
                {"pg70_dsa.yaml is a gripper, and no hand"}},
        Mistake{"APlatformAsHand",
                kPlatform,
                "hand: sdh2",
                "hand: pa10_barrett",
                {"pa10_barrett.yaml is a platform, and no hand"}},
        Mistake{"NoSuchBase",
                kPlatform,
                "base: base_link",
                "base: bas_link",
                {"kr5_sdh.yaml:4", "'bas_link'", "The nearest is 'base_link'"}},
        Mistake{"NoSuchFlange",
                kPlatform,
                "flange: tool0",
                "flange: tol0",
                {"kr5_sdh.yaml:5", "'tol0'", "The nearest is 'tool0'"}},
        Mistake{"FlangeAboveTheBase",
                kPlatform,
                "base: base_link\nflange: tool0",
                "base: tool0\nflange: base_link",
                {"kr5_sdh.yaml:5", "'base_link'", "is not below 'tool0'"}},
        Mistake{"FlangeAtTheBase",
                kPlatform,
                "base: base_link",
                "base: tool0",
                {"No joint moves between 'tool0' and 'tool0'"}},
        Mistake{"NoHomes", kPlatform, "homes:[^]*", "homes: {}", {"homes is missing or empty"}},
        Mistake{"NoHomeCalledHome", kPlatform, "  home:", "  front:", {"none that is called home"}},
        Mistake{"TwoHomesOfOneName", kPlatform, "  side:", "  home:", {"home"}},
        Mistake{"HomeBeyondTheLimits",
                kPlatform,
                "axis_5: 1.57",
                "axis_5: 9.57",
                {"homes.home", "axis_5", "is beyond 120.0 deg"}},
        Mistake{"HomeOfAJointThatIsNotThere",
                kPlatform,
                "axis_5: 1.57",
                "axs_5: 1.57",
                {"axis_5 is missing"}},
        Mistake{"MountThatIsNoNumber", kPlatform, "0, 0, 0.02", "0, 0, .nan", {"3 finite numbers"}},
        // The arm's URDF.
        Mistake{"ArmOfMacros", kArm, "<link ", "<xacro:arm/><link ", {"xacro ", "> robot.urdf"}},
        Mistake{"TwoLinksOfOneName",
                kArm,
                "</robot>",
                "<link name=\"tool0\"/></robot>",
                {"tool0", "not unique"}},
        Mistake{"TwoJointsOfOneName",
                kArm,
                "<joint name=\"axis_2\"",
                "<joint name=\"axis_1\"",
                {"axis_1", "not unique"}},
        Mistake{"LimitThatIsNoNumber", kArm, "lower=\"[^\"]*\"", "lower=\"nan\"", {"nan"}},
        Mistake{"LimitInWords", kArm, "upper=\"[^\"]*\"", "upper=\"far\"", {"far"}},
        Mistake{"LimitWithoutEnd", kArm, "upper=\"[^\"]*\"", "upper=\"inf\"", {"inf"}},
        Mistake{"LimitThatNothingReaches",
                kArm,
                "upper=\"[^\"]*\"",
                "upper=\"1e300\"",
                {"joint 'axis_1'", "that nothing reaches"}},
        Mistake{"LimitsThatCross",
                kArm,
                "upper=\"[^\"]*\"",
                "upper=\"-9\"",
                {"lower limit above the upper"}},
        Mistake{"ArmWithoutVelocity",
                kArm,
                "velocity=\"[^\"]*\"",
                "velocity=\"0\"",
                {"joint 'axis_1' of kr5_sixx_r850.urdf has no velocity limit", "velocity="}},
        Mistake{"NegativeVelocity",
                kArm,
                "velocity=\"[^\"]*\"",
                "velocity=\"-1\"",
                {"joint 'axis_1'", "velocity"}},
        Mistake{"PlaceThatIsNoNumber",
                kArm,
                "origin xyz=\"[^\"]*\"",
                "origin xyz=\"0 0 nan\"",
                {"nan"}},
        Mistake{"AShapeWithoutVolume",
                kArm,
                "box size=\"[^\"]*\"",
                "box size=\"0 1 1\"",
                {"link 'link_1'", "without volume"}},
        Mistake{"NegativeRadius",
                kArm,
                "cylinder radius=\"[^\"]*\"",
                "cylinder radius=\"-1\"",
                {"link 'base_link'", "without volume"}},
        Mistake{"AMeshThatIsNotThere",
                kArm,
                "<box [^>]*>",
                "<mesh filename=\"none.stl\"/>",
                {"link 'link_1'", "none.stl' is not there"}},
        // The hand.
        Mistake{"NoSuchUrdf",
                kHand,
                "urdf: schunk_sdh2",
                "urdf: schunk_sdh",
                {"sdh2.yaml:4", "schunk_sdh.urdf' cannot be read"}},
        Mistake{
            "UrdfIsAFolder", kHand, "urdf: [^\n]*", "urdf: .", {"sdh2.yaml:4", "cannot be read"}},
        Mistake{"NoFingers",
                kHand,
                "fingers:[^]*\nfriction",
                "fingers: {}\nfriction",
                {"hand.fingers is empty"}},
        Mistake{"ALinkInTwoFingers",
                kHand,
                "finger_2: .finger_2_knuckle, finger_2_proximal_link, finger_2_distal_link.",
                "finger_2: [finger_1_knuckle, finger_1_proximal_link, finger_1_distal_link]",
                {"hand.fingers.finger_2", "which 'finger_1' has already"}},
        Mistake{"TwoPreshapesOfOneName", kHand, "  pinch:", "  parallel:", {"parallel"}},
        Mistake{"NoPreshapes", kHand, "preshapes:[^]*", "", {"preshapes is missing"}},
        Mistake{"PreshapeOfAJointThatIsNotThere",
                kHand,
                "open: .pivot: 0,",
                "open: {pivt: 0,",
                {"preshapes.parallel.open.pivt", "The nearest is 'pivot'"}},
        Mistake{"PreshapeBeyondTheLimits",
                kHand,
                "finger_1_distal: 0.45",
                "finger_1_distal: 4.5",
                {"joint 'finger_1_distal' at 257.8 deg is beyond 90.0 deg"}},
        Mistake{"HandWithoutVelocity",
                kSdh,
                "velocity=\"[^\"]*\"",
                "velocity=\"0\"",
                {"'pivot', which has no velocity"}},
        Mistake{"HandWithoutEffort",
                kSdh,
                "effort=\"[^\"]*\"",
                "effort=\"0\"",
                {"'pivot', which has no effort"}},
        Mistake{"HandThatTurnsWithoutEnd",
                kSdh,
                "type=\"revolute\"",
                "type=\"continuous\"",
                {"'pivot' of schunk_sdh2.urdf turns without end"}},
        Mistake{"MassThatIsNoNumber", kSdh, "mass value=\"[^\"]*\"", "mass value=\"nan\"", {"nan"}},
        // Mimics.
        Mistake{"AMimicsBMimicsA",
                "barrett_bh8.urdf",
                "(<joint name=\"finger_1_inner\"[^]*?)</joint>",
                "$1<mimic joint=\"finger_1_outer\"/></joint>",
                {"mimics itself"},
                "bh8.yaml"},
        Mistake{"AJointMimicsItself",
                kPg70,
                "mimic joint=\"opening\"",
                "mimic joint=\"opening_right\"",
                {"mimics itself"},
                "pg70.yaml"},
        Mistake{"MimicOfAJointThatIsNotThere",
                kPg70,
                "mimic joint=\"opening\"",
                "mimic joint=\"openin\"",
                {"mimics 'openin'", "The nearest is 'opening'"},
                "pg70.yaml"},
        Mistake{"MimicByNoNumber",
                kPg70,
                "multiplier=\"1\"",
                "multiplier=\"nan\"",
                {"nan"},
                "pg70.yaml"},
        Mistake{"MimicByNothing",
                kPg70,
                "multiplier=\"1\"",
                "multiplier=\"0\"",
                {"mimics", "multiplier"},
                "pg70.yaml"}),
    [](const auto& one) { return one.param.name; });

class NamedRobot : public RobotFile {};

TEST_F(NamedRobot, AFingerWithoutShapesCouldTouchNothing) {
  std::string urdf = text_of(folder_ / kSdh);
  for (std::size_t at; (at = urdf.find("<collision>")) != std::string::npos;) {
    urdf.erase(at, urdf.find("</collision>") + 12 - at);
  }
  std::ofstream(folder_ / kSdh) << urdf;
  EXPECT_THAT(error_of([&] { read_hand_model(folder_ / kHand); }),
              HasSubstr("hand.fingers.finger_1 could touch nothing"));
}

TEST_F(NamedRobot, AHandIsNoPlatformAndMayHaveNoPads) {
  EXPECT_THAT(error_of([&] { read_platform(folder_ / "sdh2.yaml"); }),
              HasSubstr("sdh2.yaml is a hand, and no platform"));
  EXPECT_TRUE(read_platform(platform_without_pads(folder_)).hand.pads.empty());
}

TEST_F(NamedRobot, IsANameInTheFolderOrAFilesPath) {
  const std::string own = (folder_ / "kr5_sdh.yaml").string();
  EXPECT_EQ(platform_file("config/robots", own), own);
  EXPECT_EQ(platform_file("config/robots", "config/robots/kr5_sdh.yaml"),
            "config/robots/kr5_sdh.yaml");
  EXPECT_EQ(platform_file(folder_, "kr5_sdh"), own);
  EXPECT_EQ(platform_file(folder_, "kr5_sdh.yaml"), own);
  EXPECT_EQ(hand_file(folder_, (folder_ / "sdh2.yaml").string()), folder_ / "sdh2.yaml");
  EXPECT_THAT(error_of([&] { platform_file(folder_, "kr5_sdhh"); }),
              HasSubstr("The nearest is 'kr5_sdh'"));
  EXPECT_THAT(error_of([&] { platform_file(folder_, "/none/such.yaml"); }),
              HasSubstr("no file '/none/such.yaml' of a platform"));
  EXPECT_NE(error_of([&] { platform_file(folder_, ""); }), "");
}

}  // namespace
}  // namespace prehend::robot
