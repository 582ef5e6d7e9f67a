// Hands learned from robots' files: what is known of them, a finger that closes, what is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/robot/learning/arm_for_hand.h"
#include "prehend/robot/learning/joint_offsets.h"
#include "prehend/robot/learning/learned_hand.h"
#include "prehend/robot/platform.h"

namespace prehend::robot::learning {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using formats::JointDescription;
using geometry::InputError;
using testing::Contains;
using testing::HasSubstr;

std::string contents(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// A link of a URDF: a box [m] with its middle there.
std::string link(const std::string& name, const std::string& size, const std::string& middle) {
  return "<link name='" + name + "'><collision><origin xyz='" + middle +
         "'/><geometry><box size='" + size + "'/></geometry></collision></link>";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& xyz, const std::string& axis,
                  const std::string& limits, const std::string& more = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/><origin xyz='" + xyz + "'/><axis xyz='" + axis + "'/>" +
         (limits.empty() ? "" : "<limit " + limits + "/>") + more + "</joint>";
}
/// Jaws that slide along y and stand up along z, on `palm`.
std::string jaws(const std::string& palm, const std::string& prefix, const std::string& limits,
                 const std::string& more = "") {
  return link(palm, "0.08 0.1 0.06", "0 0 0.03") +
         link(prefix + "left", "0.02 0.01 0.08", "0 0.005 0.04") +
         link(prefix + "right", "0.02 0.01 0.08", "0 -0.005 0.04") +
         joint(prefix + "left_slide", "prismatic", palm, prefix + "left", "0 0 0.06", "0 1 0",
               limits) +
         joint(prefix + "right_slide", "prismatic", palm, prefix + "right", "0 0 0.06", "0 -1 0",
               limits, more);
}
constexpr const char* kSlide = "lower='0' upper='0.04' effort='60' velocity='0.1'";

class LearnHand : public testing::Test {
 protected:
  LearnHand() { fs::create_directories(folder_); }
  ~LearnHand() override { fs::remove_all(folder_); }
  fs::path robot(const std::string& parts) const {
    std::ofstream(folder_ / "robot.urdf") << "<robot name='r'>" << parts << "</robot>";
    return folder_ / "robot.urdf";
  }
  LearnedHand learn(const fs::path& file, const LearnChoices& choices = {}) const {
    return learn_hand(file, folder_ / "learned.yaml", choices);
  }
  std::string error_of(const fs::path& file, const LearnChoices& choices = {}) const {
    try {
      learn(file, choices);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
  static bool says(const LearnedHand& learned, const std::string& words) {
    for (const Said& said : learned.said) {
      if ((said.about + ": " + said.what).find(words) != std::string::npos) return true;
    }
    return false;
  }
  static std::set<std::string> names(const LearnedHand& learned, const std::vector<int>& motors) {
    std::set<std::string> result;
    for (const int motor : motors) {
      result.insert(learned.hand.actuated_names()[static_cast<std::size_t>(motor)]);
    }
    return result;
  }
  /// Preshapes close a ball in their tool's place with two fingers at least.
  static int fingers_that_close(const LearnedHand& learned, const Preshape& preshape,
                                double radius) {
    geometry::TriangleMesh ball = geometry::make_sphere(radius, 48);
    const Vector3d p_H = (learned.hand.X_HP * preshape.X_PG).translation();
    for (Vector3d& v : ball.vertices) v += p_H;
    const geometry::MeshQuery query(ball);
    const grasp::DistanceGrid grid(query);
    grasp::TouchScene scene;
    scene.object_W = &grid;
    const grasp::HandToClose ready(learned.hand);
    const auto closed = grasp::close_fingers(ready, geometry::RigidTransform::Identity(), preshape,
                                             preshape.open, scene);
    return static_cast<int>(
        std::count(closed.finger_touches.begin(), closed.finger_touches.end(), true));
  }
  const fs::path folder_ =
      fs::temp_directory_path() / ("prehend_learning_" + std::to_string(::getpid()));
};

TEST_F(LearnHand, JawsThatSlide) {
  const LearnedHand learned = learn(robot(jaws("palm", "", kSlide)));
  ASSERT_EQ(learned.anatomy.fingers.size(), 2u);
  EXPECT_EQ(learned.hand.model.links[static_cast<std::size_t>(learned.hand.palm)].name, "palm");
  // The pads are the inner faces; jaws at 0 touch each other.
  const PlacedPads pads =
      placed_pads(learned.hand, learned.anatomy, Eigen::VectorXd::Constant(2, 0.01));
  EXPECT_NEAR(pads.p_H[0].y(), 0.01, 1e-6);
  EXPECT_NEAR(pads.p_H[1].y(), -0.01, 1e-6);
  EXPECT_LT((pads.normal_H[0] + Vector3d::UnitY()).norm(), 1e-6);
  EXPECT_LT((pads.normal_H[1] - Vector3d::UnitY()).norm(), 1e-6);
  const FoundPreshape& pinch = learned.preshapes.front();
  EXPECT_NEAR(pinch.opening, 0.08, 2e-3);
  EXPECT_GT(pinch.sure, 0.9);
  const Eigen::Matrix3d R = pinch.preshape.X_PG.linear();
  EXPECT_GT(R.col(2).z(), 0.99);            // the approach
  EXPECT_GT(std::abs(R.col(1).y()), 0.99);  // the closing direction
  EXPECT_EQ(fingers_that_close(learned, learned.hand.preshapes.front(), 0.02), 2);
  // What the file lacks is said: masses.
  EXPECT_TRUE(says(learned, "masses: of 3 links are assumed"));
  EXPECT_NEAR(learned.hand.mass(), 1000 * (0.08 * 0.1 * 0.06 + 2 * 0.02 * 0.01 * 0.08), 1e-9);
}

TEST_F(LearnHand, JawsOfOneMotorWhoseFollowerHasLimitsOfItsOwn) {
  const LearnedHand learned =
      learn(robot(jaws("palm", "", kSlide, "<mimic joint='left_slide' multiplier='1'/>")));
  EXPECT_EQ(learned.hand.size(), 1);
  EXPECT_EQ(fingers_that_close(learned, learned.hand.preshapes.front(), 0.02), 2);
}

TEST_F(LearnHand, KnowsTheHandsThatWereDescribedByPeople) {
  const LearnedHand sdh = learn("config/robots/schunk_sdh2.urdf");
  ASSERT_EQ(sdh.anatomy.fingers.size(), 3u);
  int spread = 0;
  for (const FoundFinger& finger : sdh.anatomy.fingers) {
    EXPECT_EQ(finger.closing.size(), 2u);
    for (const double sense : finger.sense) EXPECT_EQ(sense, 1);  // positive angles close it
    spread += finger.turning.empty() ? 0 : 1;
    if (!finger.turning.empty()) {
      EXPECT_EQ(names(sdh, finger.turning), std::set<std::string>{"pivot"});
    }
  }
  EXPECT_EQ(spread, 2);
  for (const FoundPreshape& found : sdh.preshapes) {
    EXPECT_GT(found.preshape.X_PG.linear().col(2).z(), 0.9) << found.preshape.name;
  }
  const LearnedHand barrett = learn("config/robots/barrett_bh8.urdf");
  ASSERT_EQ(barrett.anatomy.fingers.size(), 3u);
  for (const FoundFinger& finger : barrett.anatomy.fingers) {
    EXPECT_EQ(finger.closing.size(), 1u);
    EXPECT_EQ(finger.sense.front(), 1);
    EXPECT_TRUE(finger.presses_ahead);
    if (!finger.turning.empty()) {
      EXPECT_EQ(names(barrett, finger.turning), std::set<std::string>{"spread"});
    }
  }
  for (const LearnedHand* hand : {&sdh, &barrett}) {
    int all_close = 0;
    for (const Preshape& preshape : hand->hand.preshapes) {
      all_close += fingers_that_close(*hand, preshape, 0.025) >= 2 ? 1 : 0;
    }
    EXPECT_GE(all_close, 1) << hand->hand.name;
  }
}

TEST_F(LearnHand, TheHandIsCutOffTheArm) {
  const std::string turn = "lower='-2' upper='2' effort='50' velocity='1'";
  const std::string arm =
      link("base", "0.1 0.1 0.1", "0 0 0.05") + link("upper", "0.05 0.05 0.3", "0 0 0.15") +
      link("lower", "0.05 0.05 0.3", "0 0 0.15") + link("wrist", "0.05 0.05 0.05", "0 0 0.02") +
      joint("a", "revolute", "base", "upper", "0 0 0.1", "0 0 1", turn) +
      joint("b", "revolute", "upper", "lower", "0 0 0.3", "0 1 0", turn) +
      joint("c", "revolute", "lower", "wrist", "0 0 0.3", "0 1 0", turn) +
      joint("d", "fixed", "wrist", "palm", "0 0 0.05", "1 0 0", "");
  const LearnedHand learned = learn(robot(arm + jaws("palm", "", kSlide)));
  EXPECT_EQ(learned.hand.model.links.size(), 3u);
  EXPECT_EQ(learned.hand.size(), 2);
  EXPECT_TRUE(says(learned, "arm: left out: 3 of 7 links are the hand's"));

  // Two of them are two hands: one has to be named.
  const auto other = [&](std::string text) {
    for (const char* name : {"base", "upper", "lower", "wrist"}) {
      for (std::size_t at = 0;
           (at = text.find(std::string("'") + name + "'", at)) != std::string::npos; at += 3) {
        text.insert(at + 1, "x_");
      }
    }
    for (const char* name : {"'a'", "'b'", "'c'", "'d'", "'palm'"}) {
      for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += 3) {
        text.insert(at + 1, "x_");
      }
    }
    return text;
  };
  const fs::path both = robot(link("torso", "0.2 0.2 0.2", "0 0 0") + arm +
                              jaws("palm", "", kSlide) + other(arm) + jaws("x_palm", "x_", kSlide) +
                              joint("l", "fixed", "torso", "base", "0 1 0", "1 0 0", "") +
                              joint("r", "fixed", "torso", "x_base", "0 -1 0", "1 0 0", ""));
  EXPECT_THAT(error_of(both),
              HasSubstr("has 2 hands. Name the palm of one, one of 'palm', 'x_palm'"));
  LearnChoices choices;
  choices.palm = "x_palm";
  EXPECT_EQ(learn(both, choices).hand.model.links.front().name, "x_palm");
  choices.palm = "x_plam";
  EXPECT_THAT(error_of(both, choices), HasSubstr("has no link 'x_plam'. The nearest is 'x_palm'"));
  choices.palm = "wrist";
  EXPECT_THAT(error_of(both, choices), HasSubstr("less than two moving fingers part"));
}

TEST_F(LearnHand, WhatIsNoHandIsRefusedInWords) {
  EXPECT_THAT(error_of(robot(link("palm", "1 1 1", "0 0 0"))),
              HasSubstr("two moving fingers part"));
  EXPECT_THAT(
      error_of(robot(link("palm", "0.1 0.1 0.1", "0 0 0") + link("f", "0.1 0.1 0.1", "0 0 0") +
                     joint("j", "prismatic", "palm", "f", "0 0 0", "1 0 0", kSlide))),
      HasSubstr("A hand has two fingers at least"));
  // Jaws that look away from each other.
  EXPECT_NE(error_of(robot(jaws("palm", "", "lower='0' upper='0.001' effort='1' velocity='1'"))),
            "");
  EXPECT_THAT(error_of(folder_ / "none.urdf"), HasSubstr("none.urdf"));
  // Fingers without any shape.
  std::string bare = jaws("palm", "", kSlide);
  for (std::size_t at; (at = bare.find("<collision>")) != std::string::npos;) {
    const std::size_t end = bare.find("</collision>");
    bare.erase(at, end + 12 - at);
  }
  EXPECT_THAT(error_of(robot(bare)), HasSubstr("has a shape"));
}

TEST_F(LearnHand, WhatTheFileLacksIsAssumedAndSaid) {
  const LearnedHand learned =
      learn(robot(jaws("palm", "", "lower='0' upper='0.04' effort='0' velocity='0'")));
  EXPECT_TRUE(says(learned, "efforts: of 2 joints are assumed"));
  EXPECT_TRUE(says(learned, "speeds: of 2 joints are assumed"));
  for (const Said& said : learned.said) {
    EXPECT_GE(said.sure, 0);
    EXPECT_LE(said.sure, 1);
  }
  const std::string yaml = contents(folder_ / "learned.yaml");
  EXPECT_THAT(yaml, HasSubstr("#   0.20  efforts: of 2 joints are assumed"));
}

TEST_F(LearnHand, PointsByWhichASimulatorCollidesAreNoPartOfAFinger) {
  std::string parts = jaws("palm", "", kSlide);
  const std::string point =
      "<collision><origin xyz='0 -0.007 0.06'/><geometry><sphere radius='0.001'/></geometry>"
      "</collision></link>";
  const auto end = parts.find("</link>", parts.find("'left'"));
  parts.replace(end, 7, point);
  const LearnedHand learned = learn(robot(parts));
  EXPECT_TRUE(says(learned, "shapes: 1 of at most 4 mm are left out"));
  const Link& left =
      learned.hand.model.links[static_cast<std::size_t>(learned.hand.model.link_index("left"))];
  ASSERT_EQ(left.shapes.size(), 1U);
  EXPECT_EQ(left.shapes[0].kind, CollisionShape::Kind::kBox);
  // A link of nothing else keeps it.
  std::string tips;
  for (const std::string side : {"left", "right"}) {
    tips += "<link name='" + side +
            "_tip'><collision><geometry><sphere radius='0.001'/></geometry>" +
            "</collision></link>" +
            joint(side + "_t", "fixed", side, side + "_tip", "0 0 0.04", "1 0 0", "");
  }
  const LearnedHand slender = learn(robot(jaws("palm", "", kSlide) + tips));
  EXPECT_FALSE(says(slender, "left out"));
}

// Engines couple joints by a ratio alone.
TEST_F(LearnHand, OffsetsOfFollowersAreWhereTheyStand) {
  formats::RobotDescription robot;
  robot.links = {{"a", {}, {}, {}}, {"b", {}, {}, {}}, {"c", {}, {}, {}}, {"d", {}, {}, {}}};
  const auto add = [&](const std::string& name, const std::string& parent, const std::string& child,
                       JointDescription::Kind kind) {
    JointDescription joint;
    joint.name = name;
    joint.kind = kind;
    joint.parent = parent;
    joint.child = child;
    joint.X_PJ.translation() = Vector3d(0.1, 0, 0);
    joint.axis_J = Vector3d(0, 0.6, 0.8);
    joint.lower = -1;
    joint.upper = 1;
    robot.joints.push_back(joint);
  };
  add("turn", "a", "b", JointDescription::Kind::kRevolute);
  add("slide", "b", "c", JointDescription::Kind::kPrismatic);
  add("last", "c", "d", JointDescription::Kind::kRevolute);
  robot.joints[1].follows = formats::Follows{"turn", 0.5, 0.02};
  robot.joints[2].follows = formats::Follows{"slide", 3, -0.3};
  robot.postures = {{"open", "", {{"slide", 0.05}}}};
  formats::RobotDescription folded = robot;
  fold_offsets(folded);
  for (const formats::JointDescription& joint : folded.joints) {
    EXPECT_EQ(joint.follows ? joint.follows->offset() : 0, 0) << joint.name;
  }
  for (const double q : {-0.5, 0.0, 0.7}) {
    const auto before = link_poses(robot, {{"turn", q}}), after = link_poses(folded, {{"turn", q}});
    for (const auto& [name, X] : before) EXPECT_TRUE(after.at(name).isApprox(X, 1e-12)) << name;
  }
  EXPECT_NEAR(*folded.joints[1].upper, 0.98, 1e-12);
  EXPECT_NEAR(*folded.joints[2].lower, -1 - (3 * 0.02 - 0.3), 1e-12);
  EXPECT_NEAR(folded.postures[0].positions.at("slide"), 0.03, 1e-12);
}

TEST_F(LearnHand, TheSameFileGivesTheSameBytes) {
  learn("config/robots/barrett_bh8.urdf");
  const std::string first = contents(folder_ / "learned.yaml");
  learn("config/robots/barrett_bh8.urdf");
  EXPECT_EQ(contents(folder_ / "learned.yaml"), first);
}

TEST_F(LearnHand, StandsOnAnArmWithItsApproachAlongTheFlange) {
  const LearnedHand learned = learn(robot(jaws("palm", "", kSlide)));
  const fs::path out = folder_ / "learned_on_pa10_barrett.yaml";
  write_text(out, platform_yaml(learned, "config/robots/pa10_barrett.yaml",
                                folder_ / "learned.yaml", out));
  const Platform platform = read_platform(out);
  EXPECT_EQ(platform.name, "learned_on_pa10_barrett");
  EXPECT_GT(platform.X_FG(platform.hand.preshapes.front()).linear().col(2).z(), 0.99);
  // One that lies in its file is turned upright, its back at the flange.
  std::string lying = jaws("palm", "", kSlide);
  const LearnedHand tilted = learn(robot(link("mount", "0.06 0.06 0.06", "0 0 0") +
                                         "<joint name='m' type='fixed'><parent "
                                         "link='mount'/><child link='palm'/><origin xyz='0.03 0 0' "
                                         "rpy='0 1.5707963 0'/></joint>" +
                                         lying));
  const geometry::RigidTransform X_FH = mount_on_flange(tilted);
  EXPECT_LT((X_FH.linear() * Vector3d::UnitX() - Vector3d::UnitZ()).norm(), 5e-3);
  EXPECT_NEAR((X_FH * Vector3d(-0.03, 0, 0)).z(), 0, 1e-3);
}

// Each of them, or a reason: what planners and converters of others stumble on.
TEST_F(LearnHand, HandsOfAllFormats) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  if (shared == nullptr || *shared == '\0')
    GTEST_SKIP() << "set PREHEND_SHARED_DATA to test hands of others";
  const fs::path models = fs::path(shared) / "models";
  struct Known {
    const char* file;
    std::size_t fingers;
  };
  for (const Known& known :
       {Known{"graspit/BarrettBH8_280_Tactile/BarrettBH8_280_Tactile.xml", 3},
        Known{"graspit/HumanHand/HumanHand20DOF.xml", 5}, Known{"graspit/McHand/McHand.xml", 3},
        Known{"sdf/gazebo_models/simple_gripper/model.sdf", 2},
        Known{"simox/Schunk_SAH/SAH_RightHand.xml", 4},
        Known{"simox/ArmarIII/ArmarIII-RightArm.xml", 5},
        Known{"urdf/allegro_hand_description/allegro_hand_description_right.urdf", 4}}) {
    const LearnedHand learned = learn(models / known.file);
    EXPECT_EQ(learned.hand.fingers.size(), known.fingers) << known.file;
    int closing = 0;
    for (const Preshape& preshape : learned.hand.preshapes) {
      closing += fingers_that_close(learned, preshape, 0.025) >= 2 ? 1 : 0;
    }
    EXPECT_GE(closing, 1) << known.file;
  }
  EXPECT_THAT(error_of(models / "graspit/HumanFinger/HumanFinger.xml"),
              HasSubstr("closes on nothing"));
}

}  // namespace
}  // namespace prehend::robot::learning
