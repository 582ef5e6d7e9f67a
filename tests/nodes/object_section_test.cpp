#include "nodes/report/object_section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::nodes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class NoRobotDrawn : public DrawnRobot {
 public:
  std::vector<std::string> pads() const override { return {}; }
  std::vector<report::ColoredMesh> hand_at(const msgs::Grasp&) const override { return {}; }
  std::vector<report::ColoredMesh> arm_at(const msgs::Grasp&) const override { return {}; }
  std::string closing_text(const msgs::Grasp&) const override { return ""; }
};

TEST(ObjectSection, SaysWhatWouldHelp) {
  Collected collected;
  msgs::GraspPlan& plan = collected.plans[0];
  plan.set_outcome(msgs::GraspPlan::UNGRASPABLE);
  plan.set_problem("it is too wide");
  msgs::Remedy& remedy = *plan.add_remedies();
  remedy.set_grasps(212);
  remedy.set_text("with 6 mm more opening (75 mm): 212 grasps");
  plan.add_remedies_in_vain("nothing beside it");
  plan.set_remedies_incomplete(true);
  report::Page page("object");
  add_object(page, collected, msgs::CompletedShape(), NoRobotDrawn(), "Object 0");
  EXPECT_THAT(page.html(), AllOf(HasSubstr("Not graspable: it is too wide"),
                                 HasSubstr("with 6 mm more opening (75 mm): 212 grasps"),
                                 HasSubstr("<td>212</td>"), HasSubstr("with nothing beside it"),
                                 HasSubstr("more was not tried in time")));
}

}  // namespace
}  // namespace prehend::nodes
