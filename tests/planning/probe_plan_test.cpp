// Every platform finds a way to touch a box with one fingertip, by its model alone.

#include "prehend/planning/probe_plan.h"

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/robot/platform.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;

constexpr double kReach = 0.08, kTip = 0.006;  // m

ProbeWay way_to(const Vector3d& at_W, const Vector3d& out) {
  return {at_W + (kTip + kReach) * out, at_W, kTip, 1};
}

class ProbePlan : public testing::TestWithParam<const char*> {
 protected:
  surface::ObjectModel box() const {
    return surface::model_of_mesh(geometry::transformed(
        geometry::make_box({0.05, 0.05, 0.14}),
        geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, 0.07})));
  }
  PlannedProbe plan(const std::vector<ProbeWay>& ways, const ProbePlanOptions& options = {}) const {
    PlatformPickOptions arm;
    arm.pick.budget = 0;
    const surface::ObjectModel object = box();
    return plan_probe(platform_, grasp::HandToClose(platform_.hand), platform_.home("side").arm,
                      ways, object, {geometry::Plane(), object.convex_pieces_W, {}}, arm, options);
  }

  const robot::Platform platform_ =
      robot::read_platform(std::string("config/robots/") + GetParam() + ".yaml");
};

// The tip goes along the way's line, and is where the box is when it is expected to.
TEST_P(ProbePlan, AFingertipGoesStraightToTheWaysEnd) {
  const std::vector<ProbeWay> ways{way_to({0, 0, 0.14}, Vector3d::UnitZ()),
                                   way_to({0, 0.025, 0.1}, Vector3d::UnitY()),
                                   way_to({-0.025, 0, 0.1}, -Vector3d::UnitX())};
  int made = 0;
  for (const ProbeWay& way : ways) {
    SCOPED_TRACE(way.at_W.transpose());
    const PlannedProbe probe = plan({way});
    if (probe.segments.empty()) {
      EXPECT_NE(probe.problem, "");
      continue;
    }
    ++made;
    ASSERT_EQ(probe.segments.size(), 2u);
    EXPECT_EQ(probe.segments[0].kind, motion::SegmentKind::kReach);
    EXPECT_EQ(probe.segments[1].kind, motion::SegmentKind::kApproach);
    const robot::KinematicChain chain = platform_.arm_chain();
    const motion::BlendedTrajectory& approach = *probe.segments[1].trajectory;
    const Vector3d d_W = (way.at_W - way.start_W).normalized();
    const geometry::MeshQuery object(box().mesh_W);
    double speed = 0;
    for (int i = 0; i <= 50; ++i) {
      const double time = approach.duration() * i / 50, later = time + 1e-3;
      const auto tip = [&](double at) {
        return platform_.X_WB * chain.forward(approach.at(at).position) * platform_.X_FH *
               probe.tip_H;
      };
      const Vector3d p_W = tip(time), r = p_W - way.at_W;
      EXPECT_LT((r - r.dot(d_W) * d_W).norm(), 0.002) << "beside the line, at " << time;
      speed = std::max(speed, (tip(later) - p_W).norm() / 1e-3);
    }
    EXPECT_LT(speed, 1.2 * ProbePlanOptions().speed);
    const Vector3d last = platform_.X_WB *
                          chain.forward(approach.at(approach.duration()).position) *
                          platform_.X_FH * probe.tip_H;
    EXPECT_LT(object.signed_distance(last), 0) << "as far as the box is expected, and beyond";
    ASSERT_EQ(probe.stops.size(), 1u);
    EXPECT_LT(probe.stops.front(), probe.hand.pregrasp_distance);
  }
  EXPECT_GE(made, 1);
}

TEST_P(ProbePlan, TheBestWayThatCanBeMadeIsTaken) {
  // From below nobody comes.
  const ProbeWay below{{0, 0, -0.08}, {0, 0, 0}, kTip, 2};
  const PlannedProbe probe = plan({below, way_to({0, 0, 0.14}, Vector3d::UnitZ())});
  EXPECT_EQ(probe.way, 1) << probe.problem;
  const PlannedProbe none = plan({below});
  EXPECT_TRUE(none.segments.empty());
  EXPECT_THAT(none.problem, testing::HasSubstr("in none of 1 ways"));
  EXPECT_NE(plan({}).problem, "");
}

TEST_P(ProbePlan, RefusesWhatIsNoWay) {
  const double nan = std::nan("");
  EXPECT_THROW(plan({{{nan, 0, 0}, {0, 0, 0}, kTip, 1}}), std::invalid_argument);
  EXPECT_THROW(plan({{{0, 0, 1}, {0, 0, 1}, kTip, 1}}), std::invalid_argument);
  EXPECT_THROW(plan({{{0, 0, 1}, {0, 0, 0}, nan, 1}}), std::invalid_argument);
  ProbePlanOptions options;
  options.speed = 0;
  EXPECT_THROW(plan({}, options), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Platforms, ProbePlan,
                         testing::Values("stage_pg70", "kr5_pg70", "kr5_sdh", "pa10_barrett"));

}  // namespace
}  // namespace prehend::planning
