#include "nodes/grasp_cycle/view.h"

#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"

namespace prehend::nodes {
namespace {

using std::chrono::seconds;
using Time = std::chrono::steady_clock::time_point;

const Lacks kAnything = [](const msgs::Grasp&) { return std::string(); };

std::shared_ptr<msgs::GraspPlan> plan(std::uint32_t id, double score, std::uint32_t count = 2) {
  auto message = std::make_shared<msgs::GraspPlan>();
  message->set_id(id);
  message->set_object_count(count);
  message->mutable_header()->set_stamp(7);
  if (score <= 0) {
    message->set_outcome(msgs::GraspPlan::UNGRASPABLE);
    message->set_problem("too wide");
    return message;
  }
  message->set_outcome(msgs::GraspPlan::GRASPABLE);
  message->add_grasps()->set_score(score);
  return message;
}

std::shared_ptr<msgs::ObjectModel> model(std::uint32_t id, double vote, double confidence = 0,
                                         double occluded_share = 0) {
  auto message = std::make_shared<msgs::ObjectModel>();
  message->set_id(id);
  message->set_vote(vote);
  message->set_confidence(confidence);
  message->set_occluded_share(occluded_share);
  message->mutable_header()->set_stamp(7);
  return message;
}

TEST(ViewCollector, IsReadyWhenEveryPlanAndModelHasCome) {
  ViewCollector views(seconds(8));
  const Time start{};
  views.add(plan(0, 0.5), start);
  views.add(model(0, 0));
  views.add(model(1, 0));
  EXPECT_EQ(views.newest_ready(start + seconds(7)), nullptr);
  views.add(plan(1, 0.5), start + seconds(7));
  EXPECT_NE(views.newest_ready(start + seconds(7)), nullptr);
}

TEST(ViewCollector, GivesUpWaitingAfterItsPatience) {
  ViewCollector views(seconds(8));
  const Time start{};
  EXPECT_EQ(views.newest_ready(start), nullptr);
  views.add(plan(0, 0.5), start);
  EXPECT_EQ(views.newest_ready(start + seconds(7)), nullptr);
  EXPECT_NE(views.newest_ready(start + seconds(8)), nullptr);
}

// Regression: a table that was cleared of its only thing was looked at until look_timeout.
TEST(ViewCollector, SaysThatNothingIsSeenOnceItIsSure) {
  ViewCollector views(seconds(8));
  const Time start{};
  msgs::ObjectHypotheses seen;
  seen.set_problem("The table is empty");
  for (const int second : {1, 2, 3}) {
    seen.mutable_header()->set_stamp(10 * second);
    views.add(seen, start + seconds(second));
  }
  EXPECT_EQ(views.why_nothing(start + seconds(3), 10), "The table is empty");
  EXPECT_EQ(views.why_nothing(start + seconds(3), 20), "") << "the first was a second ago";
  EXPECT_EQ(views.why_nothing(start + seconds(4), 20), "The table is empty");
  EXPECT_EQ(views.why_nothing(start + seconds(60), 31), "") << "seen before";
  seen.add_objects();
  views.add(seen, start + seconds(4));
  EXPECT_EQ(views.why_nothing(start + seconds(60), 10), "") << "seen after all";
}

TEST(ViewCollector, OfWhatWasSeenSinceAStamp) {
  ViewCollector views(seconds(8));
  const Time start{};
  views.add(plan(0, 0.5, 1), start);
  views.add(model(0, 0));
  EXPECT_NE(views.newest_ready(start, 7), nullptr);
  EXPECT_EQ(views.newest_ready(start, 8), nullptr);
  auto later = plan(0, 0.4, 1);
  later->mutable_header()->set_stamp(9);
  views.add(later, start);
  EXPECT_EQ(views.newest_ready(start, 8), nullptr) << "its model has not come";
  const View* view = views.newest_ready(start + seconds(8), 8);
  ASSERT_NE(view, nullptr);
  EXPECT_EQ(view->plans.at(0)->header().stamp(), 9);
}

std::shared_ptr<msgs::GraspPlan> push(std::uint32_t id, double room) {
  auto message = plan(id, 0);
  message->mutable_push()->set_score(room);
  message->mutable_push()->add_arm();
  message->mutable_push()->add_hand_joint_name("jaw");
  message->mutable_push()->add_open_position(0);
  message->mutable_push()->add_closed_position(0);
  return message;
}

TEST(ChoosePush, TakesTheOneWithMostRoom) {
  const OfObject none_left_out = [](const msgs::GraspPlan&) { return false; };
  const OfObject second_left_out = [](const msgs::GraspPlan& one) { return one.id() == 2; };
  View view;
  EXPECT_EQ(choose_push(view, none_left_out), nullptr);
  view.plans[0] = plan(0, 0);
  EXPECT_EQ(choose_push(view, none_left_out), nullptr);
  view.plans[1] = push(1, 0.4);
  view.plans[2] = push(2, 1);
  view.plans[3] = push(3, 0.9);
  EXPECT_EQ(choose_push(view, none_left_out)->id(), 2u);
  EXPECT_EQ(choose_push(view, second_left_out)->id(), 3u);
  auto without_motion = push(4, 1);
  without_motion->mutable_push()->clear_arm();
  view.plans[4] = without_motion;
  EXPECT_EQ(choose_push(view, second_left_out)->id(), 3u) << "none can be made";
}

TEST(NearestObject, IsTheOneWhoseCentroidIsNearest) {
  auto near = plan(4, 0.5), far = plan(7, 0.9);
  *near->mutable_centroid() = convert::to_message(Eigen::Vector3d(0.1, 0, 0.05));
  *far->mutable_centroid() = convert::to_message(Eigen::Vector3d(-0.2, 0, 0.05));
  View view;
  EXPECT_EQ(nearest_object(view, {0, 0, 0}), -1);
  view.plans = {{4, near}, {7, far}};
  EXPECT_EQ(nearest_object(view, {0.05, 0, 0.04}), 4);
  EXPECT_EQ(nearest_object(view, {-0.1, 0, 0.04}), 7);
}

TEST(ChooseTarget, WeighsTheScoreByHowWellTheShapeExplainsTheView) {
  View view;
  view.plans = {{0, plan(0, 0.5)}, {1, plan(1, 0.4)}};
  view.models = {{0, model(0, 0.1)}, {1, model(1, 0.1)}};
  EXPECT_EQ(choose_target(view, -1, kAnything).id, 0u);
  view.models[0] = model(0, 1.5);
  EXPECT_EQ(choose_target(view, -1, kAnything).id, 1u);
  EXPECT_EQ(choose_target(view, 0, kAnything).id, 0u);  // asked for by name
  view.models = {{0, model(0, 0.1, 0.9)}, {1, model(1, 0.1, 0.95)}};
  EXPECT_EQ(choose_target(view, -1, kAnything).id, 0u);
  view.models[0] = model(0, 0.1, 0.3);
  EXPECT_EQ(choose_target(view, -1, kAnything).id, 1u);
  view.models[1] = model(1, 0.1, 0.95, 0.4);
  EXPECT_EQ(choose_target(view, -1, kAnything).id, 0u);  // 1 goes on behind another object
  auto cut = model(1, 0.0);
  cut->set_touches_image_border(true);
  view.models[1] = cut;
  EXPECT_EQ(choose_target(view, -1, kAnything).id, 0u);  // 1 was only partly in view
}

// Once a ball that the jaws could not get round was tried three times, beside a can.
TEST(ChooseTarget, TakesLastWhatComesLast) {
  View view;
  view.plans = {{0, plan(0, 0.5)}, {1, plan(1, 0.02)}};
  view.models = {{0, model(0, 0.1)}, {1, model(1, 0.1)}};
  const auto first = [](const msgs::GraspPlan& one) { return one.id() == 0; };
  EXPECT_EQ(choose_target(view, -1, kAnything, nullptr, first).id, 1u);
  EXPECT_EQ(choose_target(view, 0, kAnything, nullptr, first).id, 0u);  // asked for by name
  view.plans.erase(1);
  EXPECT_EQ(choose_target(view, -1, kAnything, nullptr, first).id, 0u);
}

TEST(MetTooEarly, IsOnAnApproachNotWhereItIsPutDown) {
  using control::SurpriseKind;
  using Surprises = std::vector<control::Surprise>;
  const control::Surprise approach{SurpriseKind::kTouchedTooEarly, 0, 20, 0, true, ""};
  const control::Surprise place{SurpriseKind::kTouchedTooEarly, 2, 20, 0, true, ""};
  const control::Surprise slipped{SurpriseKind::kHeldAfterLift, 1, 0, 0, true, ""};
  EXPECT_FALSE(met_too_early({}));
  EXPECT_FALSE(met_too_early(Surprises{place, slipped}));
  EXPECT_TRUE(met_too_early(Surprises{approach, slipped}));
}

TEST(ChooseTarget, SaysWhyNothingCanBeGrasped) {
  View view;
  view.plans = {{0, plan(0, 0)}, {3, plan(3, 0)}};
  const Target all = choose_target(view, -1, kAnything);
  EXPECT_EQ(all.outcome, grasp::PlanOutcome::kUngraspable);
  EXPECT_TRUE(all.grasps.empty());
  EXPECT_EQ(all.problem, "object 0: too wide; object 3: too wide");
  // The planner's answer is not told by its words.
  auto unplanned = plan(3, 0);
  unplanned->set_problem("no approach");
  view.plans[3] = unplanned;
  EXPECT_EQ(choose_target(view, 3, kAnything).outcome, grasp::PlanOutcome::kUngraspable);
  EXPECT_EQ(choose_target(view, 3, kAnything).problem, "no approach");
  // Nobody knows whether what could not be planned on can be grasped.
  unplanned->set_outcome(msgs::GraspPlan::FAILED);
  unplanned->set_problem("planning failed: cannot be grasped: the mesh has a hole");
  const Target some = choose_target(view, -1, kAnything);
  EXPECT_EQ(some.outcome, grasp::PlanOutcome::kFailed);
  EXPECT_EQ(some.problem,
            "no grasp: object 0: too wide; object 3: planning failed: cannot be grasped: the mesh "
            "has a hole");
  const Target missing = choose_target(view, 9, kAnything);
  EXPECT_EQ(missing.outcome, grasp::PlanOutcome::kFailed);
  EXPECT_NE(missing.problem.find("no object 9"), std::string::npos);
}

TEST(ChooseTarget, LeavesPlansThatContradictThemselves) {
  View view;
  auto unknown = plan(0, 0.9), empty = plan(1, 0.9), old = plan(2, 0.9);
  unknown->set_outcome(static_cast<msgs::GraspPlan::Outcome>(7));
  empty->clear_grasps();
  old->clear_outcome();
  view.plans = {{0, unknown}, {1, empty}, {2, old}, {3, plan(3, 0.1)}};
  const Target good = choose_target(view, -1, kAnything);
  EXPECT_EQ(good.id, 3u);
  EXPECT_EQ(good.outcome, grasp::PlanOutcome::kGraspable);
  view.plans.erase(3);
  const Target none = choose_target(view, -1, kAnything);
  EXPECT_EQ(none.outcome, grasp::PlanOutcome::kFailed);
  for (const char* said : {"object 0: A grasp plan with an outcome that is unknown (7)",
                           "object 1: A grasp plan with the outcome 'graspable' and 0 grasps",
                           "object 2: A grasp plan with the outcome 'failed' and 1 grasps"}) {
    EXPECT_NE(none.problem.find(said), std::string::npos) << none.problem;
  }
}

TEST(ChooseTarget, TakesOnlyWhatTheRobotCanExecute) {
  View view;
  auto best = plan(0, 0.9), other = plan(1, 0.4);
  best->mutable_grasps(0)->set_preshape("far");
  other->add_grasps()->set_preshape("far");
  view.plans = {{0, best}, {1, other}};
  const Lacks lacks = [](const msgs::Grasp& grasp) -> std::string {
    return grasp.preshape() == "far" ? "no motion of the arm" : "";
  };
  EXPECT_EQ(choose_target(view, -1, lacks).id, 1u);
  EXPECT_EQ(choose_target(view, -1, lacks).grasps.size(), 1u);
  const Target none = choose_target(view, 0, lacks);
  EXPECT_TRUE(none.grasps.empty());
  EXPECT_EQ(none.outcome, grasp::PlanOutcome::kFailed) << "another robot might";
  EXPECT_EQ(none.problem, "its grasps have no motion of the arm");
}

}  // namespace
}  // namespace prehend::nodes
