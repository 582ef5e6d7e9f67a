// What the cycle does to show what it holds to a camera.

#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/control/arm_cycle_fixture.h"
#include "tests/control/tasks.h"

namespace prehend::control {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Answers each look after `lasts` steps, as `says` of it.
struct FakeInspection : InspectionPort {
  void look(const ArmPercepts& gripped, const ArmPercepts& now) override {
    looked_at.push_back(now.positions[0]);
    gripped_at.push_back(gripped.positions[0]);
    asked = 0;
  }
  MotionStatus status() override {
    if (++asked < lasts) return MotionStatus::kMoving;
    const auto found_status = says.find(looked_at.size());
    return found_status == says.end() ? MotionStatus::kReached : found_status->second;
  }
  std::string found() override { return "the inspection's words"; }
  void stop() override { ++stops; }
  std::vector<double> looked_at, gripped_at;  // of the arm's joint
  std::map<std::size_t, MotionStatus> says;   // of the n-th look
  int asked = 0, stops = 0, lasts = 5;
};

ArmGrasp grasp_with_views() {
  ArmGrasp grasp = fake_grasp();
  grasp.views = {JointTrajectory{}, path(3, 3.4), path(3, 2.6)};
  return grasp;
}

TEST(InspectTask, ShowsEachViewAndComesBack) {
  Fakes f;
  FakeInspection inspection;
  ArmCycle cycle(doing(task_named("inspect"), {}), f.arm, f.hand);
  cycle.inspect_by(inspection);
  cycle.start({grasp_with_views()});
  f.run(cycle, 8000);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_THAT(states_of(cycle), ElementsAre("look", "approach", "grasp", "lift", "inspect",
                                            "put_back", "release", "leave", "success"));
  EXPECT_THAT(inspection.looked_at, ElementsAre(3, 3.4, 2.6));
  EXPECT_THAT(inspection.gripped_at, ElementsAre(2, 2, 2));
  EXPECT_THAT(cycle.result().reason, HasSubstr("seen from 3 of 3 sides"));
  // Out and back for each view that moves, between the lift and the way down.
  std::vector<double> ends;
  for (const JointTrajectory& asked : f.arm.asked) ends.push_back(asked.points.back().position[0]);
  EXPECT_THAT(ends, ElementsAre(1, 2, 3, 3.4, 3, 2.6, 3, 2, 1, 0));
}

TEST(InspectTask, ALookThatFailsIsNoFailedAttempt) {
  Fakes f;
  FakeInspection inspection;
  inspection.says = {{1, MotionStatus::kFailed}, {3, MotionStatus::kFailed}};
  ArmCycle cycle(doing(task_named("inspect"), {}), f.arm, f.hand);
  cycle.inspect_by(inspection);
  cycle.start({grasp_with_views()});
  f.run(cycle, 8000);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_EQ(cycle.result().attempts, 1);
  EXPECT_THAT(cycle.result().reason, HasSubstr("seen from 1 of 3 sides"));
}

// It is computed: the graph's time may run fast meanwhile, and says nothing.
TEST(InspectTask, ALookMayTakeLongerThanAMotion) {
  Fakes f;
  FakeInspection inspection;
  inspection.lasts = 1000;
  ArmCycleOptions options = doing(task_named("inspect"), {});
  options.motion_timeout = 3;
  ArmCycle cycle(options, f.arm, f.hand);
  cycle.inspect_by(inspection);
  cycle.start({grasp_with_views()});
  f.run(cycle, 8000);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_THAT(cycle.result().reason, HasSubstr("seen from 3 of 3 sides"));
  EXPECT_EQ(inspection.stops, 0);
}

// It stands where the lift has ended until it was looked at; what comes of it changes nothing.
TEST(LiftView, IsWaitedForAndChangesNothing) {
  for (const MotionStatus says : {MotionStatus::kReached, MotionStatus::kFailed}) {
    Fakes f;
    FakeInspection view;
    view.says = {{1, says}};
    ArmCycle cycle(doing(task_named("pick_and_place"), {}), f.arm, f.hand);
    cycle.view_lifts_by(view);
    cycle.start({fake_grasp()});
    f.run(cycle, 8000);
    EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
    EXPECT_THAT(view.looked_at, ElementsAre(3)) << "where the lift ends, once";
    EXPECT_THAT(view.gripped_at, ElementsAre(2));
    EXPECT_EQ(view.stops, 0);
  }
}

TEST(LiftView, WhatIsLostMeanwhileIsALoss) {
  Fakes f;
  FakeInspection view;
  view.says = {{1, MotionStatus::kMoving}};
  ArmCycle cycle(doing(task_named("pick_and_place"), {}), f.arm, f.hand);
  cycle.view_lifts_by(view);
  cycle.start({fake_grasp()});
  for (int i = 0; i < 4000 && view.looked_at.empty(); ++i) f.run(cycle, 1);
  f.weight = 0;
  f.run(cycle, 8000);
  EXPECT_FALSE(cycle.result().success());
}

TEST(InspectTask, WithoutViewsOrAnyoneWhoLooksItIsPutBack) {
  for (const bool looks : {false, true}) {
    Fakes f;
    FakeInspection inspection;
    ArmCycle cycle(doing(task_named("inspect"), {}), f.arm, f.hand);
    if (looks) cycle.inspect_by(inspection);
    ArmGrasp grasp = looks ? fake_grasp() : grasp_with_views();
    if (looks) grasp.views_problem = "the plan's words";
    cycle.start({grasp});
    f.run(cycle);
    EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
    EXPECT_TRUE(inspection.looked_at.empty());
    EXPECT_THAT(cycle.result().reason,
                HasSubstr(looks ? "the plan's words" : "nobody looks at what is held"));
  }
}

TEST(InspectTask, WhatIsLostWhileItIsTurnedIsALoss) {
  Fakes f;
  FakeInspection inspection;
  inspection.says = {{1, MotionStatus::kMoving}};
  ArmCycle cycle(doing(task_named("inspect"), {}), f.arm, f.hand);
  cycle.inspect_by(inspection);
  cycle.start({grasp_with_views()});
  for (int i = 0; i < 4000 && inspection.looked_at.empty(); ++i) f.run(cycle, 1);
  f.weight = 0;
  f.run(cycle);
  EXPECT_FALSE(cycle.result().success());
  EXPECT_THAT(cycle.result().reason, HasSubstr("lost while turning"));
}

}  // namespace
}  // namespace prehend::control
