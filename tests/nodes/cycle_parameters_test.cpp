// What can be set of the grasp cycle, and what is refused with which platform.

#include <chrono>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/graph/registry.h"
#include "tests/robot/without_pads.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Ne;
using ::testing::Optional;

class CycleParameters : public ::testing::Test {
 protected:
  /// What the node says as it ends for these parameters.
  std::string refusal(const std::vector<std::string>& parameters) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    Launched cycle("grasp_cycle", arguments, scratch_.path() / "output.txt");
    EXPECT_THAT(cycle.wait(std::chrono::seconds(20)), Optional(Ne(0)));
    return cycle.output();
  }

  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  ScratchFolder scratch_;
};

TEST_F(CycleParameters, AreRefusedWhereTheyMeanNothing) {
  EXPECT_THAT(refusal({"platform:=stage_pg70", "overrun:=0.2"}),
              HasSubstr("'overrun' does not apply with platform stage_pg70"));
  EXPECT_THAT(refusal({"platform:=stage_pg70", "holding_lost_share:=0.2"}),
              HasSubstr("'holding_lost_share' does not apply with platform stage_pg70"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "gripper_closing_speed:=0.01"}),
              HasSubstr("'gripper_closing_speed' does not apply with platform kr5_sdh"));
  EXPECT_THAT(refusal({"platform:=stage_pg70", "push_force:=20"}),
              HasSubstr("'push_force' does not apply with the task pick_and_place"));
  EXPECT_THAT(refusal({"platform:=kr5_pg70", "grip_force:=5"}), HasSubstr("its force is planned"));
  const std::string unfeeling =
      "platform:=" + platform_without_pads(scratch_.path() / "robots").string();
  for (const char* parameter :
       {"grip_force:=5", "touch_force:=1", "touch_counts:=5", "minimum_stability:=0.1"}) {
    EXPECT_THAT(refusal({unfeeling, parameter}), HasSubstr("its hand has no tactile pads"));
  }
  EXPECT_THAT(refusal({"platform:=kr5_pg70", "reacts:=true", "adaptations:=1"}),
              HasSubstr("its jaws meet in the middle"));
  EXPECT_THAT(refusal({"platform:=stage_pg70", "reacts:=true", "shift_tolerance:=0.01"}),
              HasSubstr("its jaws meet in the middle"));
  EXPECT_THAT(refusal({unfeeling, "reacts:=true", "adaptations:=1"}),
              HasSubstr("where its motors stop is not predicted"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "reacts:=false", "adaptations:=1"}),
              HasSubstr("with reacts:=false"));
  EXPECT_THAT(refusal({"platform:=stage_pg70", "reacts:=false", "largest_shortfall:=0.01"}),
              HasSubstr("'largest_shortfall' does not apply with platform stage_pg70"));
  EXPECT_THAT(refusal({"platform:=kr5_pg70", "reacts:=true", "largest_shortfall:=0.01"}),
              HasSubstr("'largest_shortfall' does not apply with platform kr5_pg70"));
}

TEST_F(CycleParameters, AreRefusedOutOfTheirRange) {
  EXPECT_THAT(refusal({"collision_force:=0"}), HasSubstr("collision_force"));
  EXPECT_THAT(refusal({"platform:=kr5_sdh", "closing_speed:=2"}), HasSubstr("closing_speed"));
  EXPECT_THAT(refusal({"surprise_weight:=-1"}), HasSubstr("surprise_weight"));
  EXPECT_THAT(refusal({"colision_force:=10"}), HasSubstr("collision_force"));
}

}  // namespace
}  // namespace prehend::testing
