// Generators and closings of another project (prehend/grasp/example), loaded at run time.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/closing/closing_registry.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/grasp/planner.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kExample = PREHEND_GRASP_EXAMPLE;
constexpr const char* kUntrue = PREHEND_UNTRUE_PLUG_IN;
constexpr const char* kOutdated = PREHEND_OUTDATED_PLUG_IN;

/// Sets a variable of the environment while it lives.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  ~Environment() { unsetenv(name_); }

 private:
  const char* name_;
};

template <class Error, class Call>
std::string refusal_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was refused";
}

surface::ObjectModel upright_box(const Eigen::Vector3d& size) {
  surface::ObjectModel object;
  object.mesh_W = moved(geometry::make_box(size), Eigen::Vector3d(0, 0, size.z() / 2));
  return object;
}

GraspPlan plan(const robot::HandModel& hand, const surface::ObjectModel& object,
               const PlannerOptions& options) {
  return plan_grasps(object, geometry::Plane{}, {}, HandToClose(hand), {}, options);
}

PlannerOptions few_candidates(const robot::HandModel& hand) {
  PlannerOptions options = default_options(hand);
  options.candidates.circles.directions_per_circle = 6;
  options.candidates.circles.rolls = 3;
  options.further_generators.clear();
  options.uncertainty.samples = 0;
  return options;
}

TEST(PlugInGenerator, OfAnotherProjectIsPlannedWith) {
  const Environment folder("PREHEND_GENERATORS", kExample);
  EXPECT_THAT(GeneratorRegistry().names(), ElementsAre("antipodal", "boxes", "circles",
                                                       "from_the_top", "medial_axis", "segments"));
  const robot::HandModel gripper = robot::parallel_hand({});
  PlannerOptions options;
  options.generators = {"from_the_top"};
  options.further_generators.clear();
  const GraspPlan found = plan(gripper, upright_box({0.04, 0.06, 0.1}), options);
  EXPECT_EQ(found.candidates, options.candidates.rolls * options.candidates.standoffs);
  ASSERT_FALSE(found.grasps.empty()) << found.problem;
  for (const Grasp& grasp : found.grasps) {
    EXPECT_EQ(grasp.generator, "from_the_top");
    EXPECT_NEAR(grasp.approach_W.z(), -1, 1e-12);
    // The ray from above met the top: fingertips are below it.
    const double tip = grasp.X_WG.translation().z() - gripper.gripper->tip_z();
    EXPECT_LT(tip, 0.1);
    EXPECT_GT(tip, 0.004);
  }
  // Beside those that ship, whose candidates stay what they are.
  options.generators = {"circles"};
  const GraspPlan alone = plan(gripper, upright_box({0.04, 0.06, 0.1}), options);
  options.generators = {"circles", "from_the_top"};
  const GraspPlan both = plan(gripper, upright_box({0.04, 0.06, 0.1}), options);
  EXPECT_EQ(both.candidates, alone.candidates + found.candidates);
}

TEST(PlugInGenerator, ThatIsNotThereIsToldWithWhatCannotBeUsed) {
  const GeneratorRegistry registry({kExample, kOutdated, kExample});
  const std::string said =
      refusal_of<std::invalid_argument>([&] { registry.create("from_the_tip"); });
  EXPECT_THAT(
      said,
      AllOf(
          HasSubstr("there is no generator 'from_the_tip'; the nearest is 'from_the_top'"),
          HasSubstr("fingertips.so cannot be used: exports no prehend_generator_interface"),
          HasSubstr("outdated_plug_in.so cannot be used: is built for interface 999, this prehend "
                    "has 1"),
          HasSubstr("from_the_top.so cannot be used: its name 'from_the_top' is taken")));
  PlannerOptions options;
  options.generators = {"from_the_top"};  // which no folder has now
  EXPECT_THAT(refusal_of<std::invalid_argument>([&] {
                plan(robot::parallel_hand({}), upright_box({0.04, 0.06, 0.1}), options);
              }),
              HasSubstr("no generator 'from_the_top'"));
}

TEST(PlugInGenerator, ThatGivesNoPosesIsRefused) {
  const Environment folder("PREHEND_GENERATORS", kUntrue);
  PlannerOptions options;
  options.generators = {"no_poses"};
  for (const auto& [seed, fault] : {std::pair(1, "X_WG is no pose"),
                                    {2, "X_WG is no pose"},
                                    {3, "approach_W is not the z axis"}}) {
    options.candidates.seed = static_cast<std::uint64_t>(seed);
    EXPECT_THAT(
        refusal_of<std::runtime_error>([&] {
          plan(robot::parallel_hand({}), upright_box({0.04, 0.06, 0.1}), options);
        }),
        AllOf(HasSubstr("generator 'no_poses', a plug-in: candidate 1: "), HasSubstr(fault)));
  }
}

TEST(PlugInClosing, OfAnotherProjectHoldsByFingertipsAlone) {
  const Environment folder("PREHEND_CLOSINGS", kExample);
  EXPECT_THAT(ClosingRegistry().names(), ElementsAre("fingers", "fingertips", "pads"));
  robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  const surface::ObjectModel object = upright_box({0.05, 0.06, 0.12});
  const PlannerOptions options = few_candidates(hand);
  const auto is_at_tips = [&](const Grasp& grasp) {
    return std::all_of(
        grasp.contacts.begin(), grasp.contacts.end(), [&](const GraspContact& contact) {
          return contact.finger >= 0 &&
                 hand.fingers[static_cast<std::size_t>(contact.finger)].links.back() ==
                     contact.link;
        });
  };
  const GraspPlan before = plan(hand, object, options);
  ASSERT_FALSE(before.grasps.empty()) << before.problem;
  EXPECT_FALSE(std::all_of(before.grasps.begin(), before.grasps.end(), is_at_tips));

  hand.closing = "fingertips";
  const GraspPlan tips = plan(hand, object, options);
  ASSERT_FALSE(tips.grasps.empty()) << tips.problem;
  EXPECT_TRUE(std::all_of(tips.grasps.begin(), tips.grasps.end(), is_at_tips));
  EXPECT_EQ(tips.candidates, before.candidates);
  EXPECT_THAT(tips.rejections, Contains(::testing::Field(&Rejection::reason, Reason::kFinger)));
  const GraspPlan again = plan(hand, object, options);
  EXPECT_EQ(again.grasps.front().X_WH.matrix(), tips.grasps.front().X_WH.matrix());
}

TEST(Closings, BuiltInOnesNamedAreTheDefaults) {
  robot::HandModel fingers = robot::read_hand_model("config/robots/bh8.yaml");
  EXPECT_EQ(fingers.closing_method(), "fingers");
  robot::HandModel pads = robot::parallel_hand({});
  EXPECT_EQ(pads.closing_method(), "pads");
  for (robot::HandModel* hand : {&fingers, &pads}) {
    const surface::ObjectModel object = upright_box({0.04, 0.06, 0.1});
    const PlannerOptions options = few_candidates(*hand);
    const GraspPlan unnamed = plan(*hand, object, options);
    hand->closing = hand->closing_method();
    const GraspPlan named = plan(*hand, object, options);
    ASSERT_FALSE(named.grasps.empty()) << named.problem;
    ASSERT_EQ(named.grasps.size(), unnamed.grasps.size());
    for (std::size_t i = 0; i < named.grasps.size(); ++i) {
      EXPECT_EQ(named.grasps[i].X_WH.matrix(), unnamed.grasps[i].X_WH.matrix());
      EXPECT_EQ(named.grasps[i].score, unnamed.grasps[i].score);
    }
  }
}

TEST(Closings, ThatDoNotFitTheHandAreRefusedInWords) {
  const auto refused = [](robot::HandModel hand, const std::string& closing) {
    hand.closing = closing;
    return refusal_of<geometry::InputError>([&] { HandToClose{hand}; });
  };
  const robot::HandModel sdh = robot::read_hand_model("config/robots/sdh2.yaml");
  const robot::HandModel pg70 = robot::read_hand_model("config/robots/pg70.yaml");
  EXPECT_THAT(refused(sdh, "pads"),
              AllOf(HasSubstr("hand 'sdh2' cannot close by 'pads': it names no parallel gripper"),
                    HasSubstr("Correct `closing`")));
  EXPECT_THAT(refused(pg70, "fingers"), HasSubstr("cannot close by 'fingers': it is a parallel"));
  EXPECT_THAT(
      refused(sdh, "fingrs"),
      AllOf(HasSubstr("hand 'sdh2': there is no closing 'fingrs'; the nearest is 'fingers'"),
            HasSubstr("there are fingers, pads"), HasSubstr("PREHEND_CLOSINGS")));
  const Environment folder("PREHEND_CLOSINGS", std::string(kExample) + ":" + kOutdated);
  EXPECT_THAT(refused(pg70, "fingertips"), HasSubstr("closes by pads, and has no fingertips"));
  EXPECT_THAT(refused(sdh, "tips"),
              AllOf(HasSubstr("fingers, fingertips, pads"),
                    HasSubstr("outdated_plug_in.so cannot be used: is built for interface 999")));
}

TEST(PlugInClosing, WhoseGraspsAreNotOfTheHandIsRefused) {
  const Environment folder("PREHEND_CLOSINGS", kUntrue);
  robot::HandModel hand = robot::read_hand_model("config/robots/sdh2.yaml");
  hand.closing = "everything";
  EXPECT_THAT(refusal_of<std::runtime_error>([&] {
                plan(hand, upright_box({0.04, 0.06, 0.1}), few_candidates(hand));
              }),
              HasSubstr("closing 'everything', a plug-in: its grasp's open has not a position"));
}

}  // namespace
}  // namespace prehend::grasp
