#include "nodes/report/verdict.h"

#include <gtest/gtest.h>

#include "nodes/report/compose.h"

namespace prehend::nodes {
namespace {

Collected successful_run(double raised, double moved, double end_height) {
  Collected collected;
  collected.result.emplace();
  collected.result->set_success(true);
  collected.result->set_reason("lifted");
  collected.bodies["other"].height = {{0, 0.0}, {1, 0.002}};
  collected.bodies["other"].horizontal = {{0, 0.0}, {1, 0.0}};
  auto& body = collected.bodies["carton"];
  body.height = {{0, 0.0}, {1, raised}, {2, end_height}};
  body.horizontal = {{0, 0.0}, {1, moved}, {2, moved}};
  return collected;
}

TEST(Verdict, BelievesTheSimulatorsTruthNotTheCycle) {
  EXPECT_TRUE(judge(successful_run(0.15, 0.15, 0.0), true, "").success);
  EXPECT_FALSE(judge(successful_run(0.09, 0.15, 0.0), true, "").success);
  EXPECT_FALSE(judge(successful_run(0.15, 0.0, 0.0), true, "").success);
  EXPECT_FALSE(judge(successful_run(0.15, 0.15, 0.12), true, "").success);
  EXPECT_EQ(measure_lift(successful_run(0.15, 0.15, 0.0)).body, "carton");
}

TEST(Verdict, CannotBeGraspedIsAnAnswerUnlessALiftIsRequired) {
  Collected collected;
  collected.result.emplace();
  collected.result->set_reason("cannot be grasped: narrowest width 94 mm");
  EXPECT_TRUE(judge(collected, false, "").success);
  EXPECT_TRUE(judge(collected, false, "").ungraspable);
  EXPECT_FALSE(judge(collected, true, "").success);
}

TEST(Verdict, NamesTheStageAtWhichTheChainBroke) {
  Collected collected;
  EXPECT_NE(judge(collected, true, "no result within 5 s").text.find("no object hypotheses"),
            std::string::npos);
  collected.objects.emplace();
  collected.objects->set_problem("no table was found");
  EXPECT_EQ(judge(collected, true, "").text, "no table was found");
  collected.objects->set_problem("");
  collected.objects->add_objects();
  EXPECT_EQ(judge(collected, true, "").text, "no completed shape came");
}

// It was green: a page on which nothing was grasped looked like a success.
TEST(Page, AnObjectThatCannotBeGraspedIsNoSuccess) {
  Collected collected;
  collected.result.emplace();
  collected.result->set_reason("cannot be grasped: narrowest width 94 mm");
  const robot::GripperModel gripper;
  const auto banner = [&](bool require_lift) {
    const std::string html =
        compose_page("t", collected, judge(collected, require_lift, ""), gripper, {}).html();
    const auto begin = html.find("<p class=\"verdict ");
    return html.substr(begin, html.find("</p>", begin) - begin);
  };
  EXPECT_EQ(
      banner(false),
      "<p class=\"verdict answer\">Nothing was grasped: cannot be grasped: narrowest width 94 "
      "mm");
  EXPECT_EQ(banner(true), "<p class=\"verdict bad\">cannot be grasped: narrowest width 94 mm");
}

TEST(Page, IsWrittenForEveryStageOfFailure) {
  Collected collected;
  const robot::GripperModel gripper;
  EXPECT_NE(compose_page("t", collected, judge(collected, true, ""), gripper, {})
                .html()
                .find("No object hypotheses came"),
            std::string::npos);
  collected.objects.emplace();
  collected.objects->add_notes("the camera looks along -z");
  collected.shapes[0].set_problem("two points only");
  collected.models[0].set_problem("no watertight mesh");
  auto page = compose_page("t", collected, judge(collected, true, ""), gripper, {}).html();
  EXPECT_NE(page.find("the camera looks along -z"), std::string::npos);
  EXPECT_NE(page.find("two points only"), std::string::npos);
  EXPECT_NE(page.find("no watertight mesh"), std::string::npos);

  // A part that cannot be drawn is said, and the rest of the page is there.
  collected.stereo.emplace();
  collected.stereo->set_width(1000);
  page = compose_page("t", collected, judge(collected, true, ""), gripper, {}).html();
  EXPECT_NE(page.find("could not be drawn"), std::string::npos);
  EXPECT_NE(page.find("Stage times"), std::string::npos);
}

}  // namespace
}  // namespace prehend::nodes
