// Probes by the shipped cycle, against the object that stands in the world.

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "prehend/control/arm_in_world.h"
#include "prehend/control/attempt_watch.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/simulation/shapes.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

class ProbeOfBox : public testing::TestWithParam<const char*> {
 protected:
  struct Probed {
    AttemptWatch watch;
    CycleResult result;
    double hardest = 0;  // N, at the wrist, until the hand is back
    double pushed = 0;   // m, of the object until then
  };
  // Believed to be larger than it is; not there at all where `standing` is false.
  Probed probe(bool standing) {
    simulation::Scene scene;
    scene.wrench.emplace();
    scene.wrench->force_noise = 0.1;
    simulation::RobotWorld world(planned_.platform(), scene, "side");
    world.add_object("thing", mesh_W_, 0.5);
    if (!standing) {
      geometry::RigidTransform away = world.body("thing").X_WB;
      away.translation().y() += 0.6;
      world.place_object("thing", away);
    }
    const Eigen::Vector3d before = world.body("thing").X_WB.translation();
    planning::PlatformPlanOptions options = planned_.plan_options();
    options.motions = 1;
    options.touch.reset();
    const Eigen::AlignedBox3d box = geometry::bounds(believed_W_);
    const double tip = 0.006, reach = 0.08;
    const Eigen::Vector3d top(0, 0, box.max().z()), side(0, box.max().y(), 0.1);
    options.probes = {{side + (tip + reach) * Eigen::Vector3d::UnitY(), side, tip, 2},
                      {top + (tip + reach) * Eigen::Vector3d::UnitZ(), top, tip, 1}};
    const planning::PlatformPlan plan = planned_.planner.plan(surface::model_of_mesh(believed_W_),
                                                              {}, {}, {}, planned_.start, options);
    GraspsToTry grasps = planned_.to_try(plan);
    const std::optional<ArmGrasp> probing = arm_probe(planned_.platform(), plan.probe);
    EXPECT_TRUE(probing) << plan.probe.problem;
    if (probing) grasps.grasps.push_back(*probing);
    ArmCycleOptions cycle = reacting();
    cycle.task = read_task(task_file("config/tasks", "probe_and_pick"));
    cycle.largest_attempts = 1;
    ArmInWorld arm(world);
    CycleInWorld in_world(arm, cycle);
    Probed probed{AttemptWatch(planned_.platform(), cycle.contact_force), {}, 0, 0};
    bool probes = true;
    in_world.run(std::move(grasps), nullptr, [&] {
      // The attempt after the probe is another one for the watch.
      const CycleResult& so_far = in_world.cycle().result();
      probes = probes && (so_far.attempts == 0 || so_far.touches == 0);
      if (!probes) return;
      probed.watch.step(in_world.cycle(), in_world.percepts());
      probed.hardest = std::max(probed.hardest, in_world.percepts().wrist_force->norm());
      probed.pushed =
          std::max(probed.pushed, (world.body("thing").X_WB.translation() - before).norm());
    });
    probed.result = in_world.cycle().result();
    return probed;
  }

  const PickOf planned_{GetParam()};
  const geometry::TriangleMesh mesh_W_ = simulation::make_standing_box({0.05, 0.05, 0.14});
  const geometry::TriangleMesh believed_W_ = simulation::make_standing_box({0.05, 0.06, 0.144});
};

TEST_P(ProbeOfBox, TouchesItGentlyWhereItIs) {
  const Probed probed = probe(true);
  EXPECT_EQ(probed.result.touches, 1) << probed.result.reason;
  ASSERT_GE(probed.watch.attempt().size(), 1u);
  const belief::Act& act = probed.watch.attempt().front();
  EXPECT_GT(act.free_way.size(), 5u) << "what it went through is empty";
  ASSERT_GE(act.contacts.size(), 1u) << probed.result.reason;
  const geometry::MeshQuery surface(mesh_W_);
  for (const belief::Contact& contact : act.contacts) {
    EXPECT_LT(surface.nearest(contact.p_W)->distance, 0.003) << contact.p_W.transpose();
  }
  EXPECT_LT(probed.hardest, 15) << "1 N, and what the arm needs to stop";
  EXPECT_LT(probed.pushed, 0.005);
  EXPECT_TRUE(probed.result.success()) << probed.result.reason;
}

TEST_P(ProbeOfBox, WhatIsNotThereIsEmptySpaceWithoutAContact) {
  const Probed probed = probe(false);
  EXPECT_EQ(probed.result.touches, 1) << probed.result.reason;
  ASSERT_GE(probed.watch.attempt().size(), 1u);
  EXPECT_GT(probed.watch.attempt().front().free_way.size(), 5u);
  for (const belief::Act& act : probed.watch.attempt()) EXPECT_TRUE(act.contacts.empty());
  EXPECT_LT(probed.pushed, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Platforms, ProbeOfBox,
                         testing::Values("stage_pg70", "kr5_pg70", "kr5_sdh", "pa10_barrett"));

}  // namespace
}  // namespace prehend::control
