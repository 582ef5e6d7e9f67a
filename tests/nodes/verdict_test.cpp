#include "nodes/report/verdict.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "nodes/report/compose.h"

namespace prehend::nodes {
namespace {

Collected successful_run(double raised, double moved, double end_height) {
  Collected collected;
  collected.result.emplace();
  collected.result->set_outcome(msgs::CycleResult::SUCCEEDED);
  collected.result->set_attempts(1);
  collected.result->set_reason("lifted");
  collected.bodies["other"].height = {{0, 0.0}, {1, 0.002}};
  collected.bodies["other"].horizontal = {{0, 0.0}, {1, 0.0}};
  auto& body = collected.bodies["carton"];
  body.height = {{0, 0.0}, {1, raised}, {2, end_height}};
  body.horizontal = {{0, 0.0}, {1, moved}, {2, moved}};
  return collected;
}

TEST(Verdict, BelievesTheSimulatorsTruthNotTheCycle) {
  EXPECT_TRUE(judge(successful_run(0.15, 0.15, 0.0), "").kind == Verdict::Kind::kSuccess);
  EXPECT_FALSE(judge(successful_run(0.09, 0.15, 0.0), "").kind == Verdict::Kind::kSuccess);
  EXPECT_FALSE(judge(successful_run(0.15, 0.0, 0.0), "").kind == Verdict::Kind::kSuccess);
  EXPECT_FALSE(judge(successful_run(0.15, 0.15, 0.12), "").kind == Verdict::Kind::kSuccess);
  EXPECT_EQ(measure_lifts(successful_run(0.15, 0.15, 0.0)).front().body, "carton");
}

// A work cycle that did what it should was once called a failure.
TEST(Verdict, IsOfTheTask) {
  Collected lifted = successful_run(0.15, 0.0, 0.0);
  lifted.result->set_attempts(1);
  msgs::Task& task = lifted.task.emplace();
  // States' names are the task's own.
  for (const auto& [name, action] :
       {std::pair{"up", msgs::Task::LIFT}, std::pair{"put away", msgs::Task::PLACE},
        std::pair{"place", msgs::Task::LIFT}}) {
    task.add_states()->set_name(name);
    task.mutable_states(task.states_size() - 1)->set_action(action);
  }
  lifted.result->add_task_path("up");
  lifted.result->add_task_path("place");
  EXPECT_EQ(judge(lifted, "").kind, Verdict::Kind::kSuccess) << "it was to be put back";
  lifted.result->add_task_path("put away");
  EXPECT_EQ(judge(lifted, "").kind, Verdict::Kind::kFailure) << "it was to be put elsewhere";
  Collected two = successful_run(0.15, 0.15, 0.0);
  two.bodies["can"] = two.bodies["carton"];
  EXPECT_EQ(judge(two, "").kind, Verdict::Kind::kSuccess);
  EXPECT_NE(judge(two, "").text.find("2 objects were moved"), std::string::npos);
}

TEST(Verdict, CannotBeGraspedIsAnAnswerOfItsOwn) {
  Collected collected;
  collected.result.emplace();
  collected.result->set_outcome(msgs::CycleResult::UNGRASPABLE);
  collected.result->set_reason("narrowest width 94 mm");
  EXPECT_EQ(judge(collected, "").kind, Verdict::Kind::kNotGraspable);
  EXPECT_EQ(judge(collected, "").text, "narrowest width 94 mm");
  // It is not told by words.
  collected.result->set_outcome(msgs::CycleResult::FAILED);
  collected.result->set_reason("cannot be grasped: narrowest width 94 mm");
  EXPECT_EQ(judge(collected, "").kind, Verdict::Kind::kFailure);
}

TEST(Verdict, AnUnknownOutcomeIsAFailureThatSaysSo) {
  Collected collected = successful_run(0.15, 0.15, 0.0);
  collected.result->set_outcome(static_cast<msgs::CycleResult::Outcome>(9));
  const Verdict verdict = judge(collected, "");
  EXPECT_EQ(verdict.kind, Verdict::Kind::kFailure);
  EXPECT_NE(verdict.text.find("an outcome that is unknown (9)"), std::string::npos) << verdict.text;
}

msgs::Grasp& executed(Collected* collected) {
  collected->result->set_attempts(1);
  msgs::GraspPlan& plan = collected->plans[collected->result->object_id()];
  return plan.grasps().empty() ? *plan.add_grasps() : *plan.mutable_grasps(0);
}

// A recorded object is lifted as it was predicted: that says nothing of the real one.
TEST(Verdict, SaysThatThePredictedMeshWasLifted) {
  Collected collected = successful_run(0.15, 0.15, 0.0);
  EXPECT_EQ(judge(collected, "").text.find("predicted"), std::string::npos);
  collected.on_prediction = true;
  EXPECT_NE(judge(collected, "").text.find("over the table, executed on the predicted mesh"),
            std::string::npos);
  executed(&collected);
  const auto rows = summarize(collected);
  const auto grasped =
      std::find_if(rows.begin(), rows.end(), [](const auto& row) { return row[0] == "grasped"; });
  ASSERT_NE(grasped, rows.end());
  EXPECT_EQ((*grasped)[1], "object 0, grasp 1, 1 attempt(s), executed on the predicted mesh");
}

TEST(Verdict, SaysHowFarTheGraspThatLiftedCanBeReliedOn) {
  Collected collected = successful_run(0.15, 0.15, 0.0);
  msgs::Grasp& grasp = executed(&collected);
  const auto text = [&] { return judge(collected, "").text; };
  EXPECT_NE(text().find(". The grasp: robustness not assessed"), std::string::npos) << text();
  grasp.set_remark("tried in case it is narrower");
  EXPECT_TRUE(
      text().ends_with(". The grasp: robustness not assessed; tried in case it is narrower"))
      << text();
  grasp.set_robustness(0.8125);
  grasp.set_remark("47 % of the contact is on surface that nobody saw");
  EXPECT_TRUE(
      text().ends_with("held in 81 % of the disturbed trials; 47 % of the contact is on "
                       "surface that nobody saw"))
      << text();
  // Not of a grasp that is not in the plan that is known.
  collected.result->set_grasp_index(3);
  EXPECT_EQ(text().find("The grasp"), std::string::npos);
}

TEST(Verdict, NamesTheStageAtWhichTheChainBroke) {
  Collected collected;
  EXPECT_NE(judge(collected, "no result within 5 s").text.find("no object hypotheses"),
            std::string::npos);
  collected.objects.emplace();
  collected.objects->set_problem("no table was found");
  EXPECT_EQ(judge(collected, "").text, "no table was found");
  collected.objects->set_problem("");
  collected.objects->add_objects();
  EXPECT_EQ(judge(collected, "").text, "no completed shape came");
}

// It was green: a page on which nothing was grasped looked like a success.
TEST(Page, HeadlinesNotGraspableAsSuch) {
  Collected collected;
  collected.result.emplace();
  const auto banner = [&] {
    const std::string html = compose_page("t", collected, judge(collected, ""),
                                          *make_drawn(robot::GripperModel{}), {}, {})
                                 .html();
    const auto begin = html.find("<p class=\"verdict ");
    return html.substr(begin, html.find("</p>", begin) - begin);
  };
  collected.result->set_outcome(msgs::CycleResult::UNGRASPABLE);
  collected.result->set_reason("narrowest width 94 mm");
  EXPECT_EQ(banner(), "<p class=\"verdict answer\">Not graspable: narrowest width 94 mm");
  collected.result->set_outcome(msgs::CycleResult::FAILED);
  collected.result->set_reason("the object slipped");
  EXPECT_EQ(banner(), "<p class=\"verdict bad\">the object slipped");
}

// The answer of an object's plan is amber, what could not be planned red, by what they are.
TEST(Page, ShowsWhatAPlanSaysOfItsObject) {
  Collected collected;
  collected.shapes[0].set_completed(true);
  msgs::GraspPlan& plan = collected.plans[0];
  const auto page = [&] {
    return compose_page("t", collected, judge(collected, ""), *make_drawn(robot::GripperModel{}),
                        {}, {})
        .html();
  };
  const auto summary = [&] { return summarize(collected)[0][1]; };
  plan.set_problem("too wide");
  plan.set_outcome(msgs::GraspPlan::UNGRASPABLE);
  EXPECT_NE(page().find("<p class=\"verdict answer\">Not graspable: too wide"), std::string::npos);
  EXPECT_TRUE(summary().ends_with("; cannot be grasped: too wide")) << summary();
  plan.set_outcome(msgs::GraspPlan::FAILED);
  EXPECT_NE(page().find("<p class=\"verdict bad\">too wide"), std::string::npos);
  EXPECT_TRUE(summary().ends_with("; too wide")) << summary();
  plan.set_outcome(static_cast<msgs::GraspPlan::Outcome>(5));
  EXPECT_NE(page().find("an outcome that is unknown (5)"), std::string::npos);
  EXPECT_NE(summary().find("an outcome that is unknown (5)"), std::string::npos) << summary();
}

// Of a camera of 4 x 3 pixels that sees one object in the middle.
msgs::ObjectHypotheses small_view() {
  perception::SegmentedScene scene;
  scene.camera = {4, 3, 4, 4, 2, 1.5};
  scene.X_WC = geometry::RigidTransform::Identity();
  scene.depth = geometry::DepthImage(4, 3, 0.8f);
  scene.depth.at(1, 1) = 0.7f;
  auto& object = scene.objects.emplace_back();
  object.cloud_W.points = {{0, 0, 0}};
  object.mask = geometry::MaskImage(4, 3);
  object.mask.at(1, 1) = 255;
  return convert::to_message(scene);
}

std::size_t pictures_in(const std::string& html) {
  std::size_t count = 0;
  for (auto at = html.find("<img"); at != std::string::npos; at = html.find("<img", at + 1)) {
    ++count;
  }
  return count;
}

// Its depth was called disparity, and its colours were not shown.
TEST(Page, ShowsARecordedCloudAsACloud) {
  Collected collected;
  collected.objects = small_view();
  const auto html = [&] {
    return compose_page("t", collected, judge(collected, ""), *make_drawn(robot::GripperModel{}),
                        {}, {})
        .html();
  };
  const std::string without = html();
  EXPECT_EQ(pictures_in(without), 2u);
  geometry::PointCloud cloud;
  cloud.width = 4;
  cloud.height = 3;
  cloud.points.assign(12, {0, 0, 0.8f});
  cloud.colors.assign(12, {200, 30, 30});
  collected.clouds.push_back(convert::to_message(cloud));
  const std::string page = html();
  EXPECT_EQ(pictures_in(page), 3u);
  EXPECT_NE(page.find("Colours of the recorded cloud"), std::string::npos);
  EXPECT_NE(page.find("Depth (red near"), std::string::npos);
  EXPECT_EQ(page.find("isparity"), std::string::npos);
  EXPECT_EQ(page.find("Left image"), std::string::npos);
  EXPECT_EQ(page.find("could not be drawn"), std::string::npos);
  // Two views: each is shown, and the masks are drawn as if there were none.
  collected.clouds.push_back(collected.clouds.front());
  const std::string two = html();
  EXPECT_EQ(pictures_in(two), 4u);
  const auto masks = without.rfind("<figure>");
  EXPECT_NE(two.find(without.substr(masks, without.find("</figure>", masks) - masks)),
            std::string::npos);
}

TEST(Page, SaysHowLargeAnObjectIsAndHowSureThatIs) {
  surface::ObjectModel model;
  model.mesh_W = geometry::make_box({0.12, 0.05, 0.03});
  for (auto& p : model.mesh_W.vertices) p.z() += 0.015;
  const std::size_t count = model.mesh_W.vertices.size();
  model.vertex_origin.assign(count, surface::SurfaceOrigin::kPredicted);
  model.vertex_confidence.assign(count, 0.6826895f);  // one standard deviation is 5 mm
  Collected collected;
  collected.shapes[0].set_completed(true);
  msgs::ObjectModel& message = collected.models[0] = convert::to_message(model);
  message.set_valid(true);
  *message.mutable_table() = convert::to_message(geometry::Plane{Eigen::Vector3d::UnitZ(), 0});
  const std::string size = "120 +- 7 x 50 +- 7 x 30 +- 5 mm";
  const auto summary = [&] { return summarize(collected)[0][1]; };
  EXPECT_NE(summary().find(size), std::string::npos) << summary();
  const auto page = [&] {
    return compose_page("t", collected, judge(collected, ""), *make_drawn(robot::GripperModel{}),
                        {}, {})
        .html();
  };
  EXPECT_NE(page().find("Length, width and height: " + size), std::string::npos);
  // What is known has the size of its mesh.
  message.mutable_known()->set_name("box");
  EXPECT_NE(summary().find("120 x 50 x 30 mm"), std::string::npos) << summary();
  // A mesh that makes no sense is told, and the page is written.
  message.mutable_mesh()->set_vertex_count(1000000);
  EXPECT_NE(summary().find("mesh"), std::string::npos);
  EXPECT_NE(page().find("could not be drawn"), std::string::npos);
}

TEST(Page, IsWrittenForEveryStageOfFailure) {
  Collected collected;
  EXPECT_NE(
      compose_page("t", collected, judge(collected, ""), *make_drawn(robot::GripperModel{}), {}, {})
          .html()
          .find("No object hypotheses came"),
      std::string::npos);
  collected.objects.emplace();
  collected.objects->add_notes("the camera looks along -z");
  collected.shapes[0].set_problem("two points only");
  collected.models[0].set_problem("no watertight mesh");
  auto page =
      compose_page("t", collected, judge(collected, ""), *make_drawn(robot::GripperModel{}), {}, {})
          .html();
  EXPECT_NE(page.find("the camera looks along -z"), std::string::npos);
  EXPECT_NE(page.find("two points only"), std::string::npos);
  EXPECT_NE(page.find("no watertight mesh"), std::string::npos);

  // A part that cannot be drawn is said, and the rest of the page is there.
  collected.stereo.emplace();
  collected.stereo->set_width(1000);
  page =
      compose_page("t", collected, judge(collected, ""), *make_drawn(robot::GripperModel{}), {}, {})
          .html();
  EXPECT_NE(page.find("could not be drawn"), std::string::npos);
  EXPECT_NE(page.find("Stage times"), std::string::npos);
}

}  // namespace
}  // namespace prehend::nodes
