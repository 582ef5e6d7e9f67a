// What attempts of the shipped cycle find out, against the object that stands in the world.

#include "prehend/control/attempt_watch.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "prehend/belief/hand_evidence.h"
#include "prehend/control/arm_in_world.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/swept_space.h"
#include "prehend/simulation/shapes.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

constexpr double kBoxMass = 0.3;       // kg
constexpr double kContactForce = 5;    // N, at the wrist
constexpr double kOnSurface = 0.0015;  // m
constexpr double kBeside = 0.03;       // m

class AttemptAtBox : public testing::TestWithParam<const char*> {
 protected:
  using Change = std::function<void(ArmPercepts&)>;

  AttemptAtBox() : world_(planned_.platform(), scene(), "side") {
    world_.add_object("thing", mesh_W_, kBoxMass);
  }

  // One attempt, as the cycle's percepts show it after `change`.
  AttemptWatch watched(const Change& change = nullptr) {
    const planning::PlatformPlan plan = planned_.plan(mesh_W_);
    ArmInWorld arm(world_);
    CycleInWorld in_world(arm, reacting());
    AttemptWatch watch(planned_.platform(), kContactForce);
    in_world.run(planned_.to_try(plan), nullptr, [&] {
      ArmPercepts percepts = in_world.percepts();
      if (change) change(percepts);
      watch.step(in_world.cycle(), percepts);
    });
    return watch;
  }

  static simulation::Scene scene() {
    simulation::Scene scene;
    scene.wrench.emplace();
    scene.wrench->force_noise = 0.1;
    return scene;
  }

  const PickOf planned_{GetParam()};
  const geometry::TriangleMesh mesh_W_ = simulation::make_standing_box({0.05, 0.05, 0.14});
  simulation::RobotWorld world_;
};

TEST_P(AttemptAtBox, FeelsItsSurfaceAndGoesThroughWhatIsEmpty) {
  const AttemptWatch watch = watched();
  EXPECT_EQ(watch.concluded(), 1);
  ASSERT_GE(watch.attempt().size(), 1u);
  const geometry::MeshQuery surface(mesh_W_);
  std::size_t contacts = 0;
  for (const belief::Act& act : watch.attempt()) {
    for (const belief::Contact& contact : act.contacts) {
      ++contacts;
      EXPECT_LT(surface.nearest(contact.p_W)->distance, kOnSurface + 2 * act.motion.along)
          << contact.p_W.transpose();
      EXPECT_GT(contact.normal_W.head<2>().norm(), 0.7)
          << "of an upright side, by a fingertip that may be bent about an edge: "
          << contact.normal_W.transpose();
    }
  }
  EXPECT_GT(contacts, 1u);
  const belief::Act& first = watch.attempt().front();
  ASSERT_GT(first.free_way.size(), 5u);
  const belief::HandEvidence evidence(planned_.platform().hand);
  Eigen::AlignedBox3d room = geometry::bounds(mesh_W_);
  room.min().array() -= kBeside;
  room.max().array() += kBeside;
  geometry::SweptSpace swept(room, 0.002);
  evidence.sweep(first.free_way, {}, &swept);
  EXPECT_FALSE(swept.empty()) << "the hand came this near";
  double deepest = 0;
  for (double x = -0.024; x < 0.025; x += 0.004) {
    for (double y = -0.024; y < 0.025; y += 0.004) {
      for (double z = 0.002; z < 0.14; z += 0.004)
        deepest = std::max(deepest, swept.depth({x, y, z}));
    }
  }
  EXPECT_LT(deepest, 0.002) << "nothing of the body is believed to be empty";
}

// A pad with an offset feels something before there is anything.
TEST_P(AttemptAtBox, DoesNotBelieveAPadThatFeelsBeforeTheApproach) {
  std::string biased;
  const AttemptWatch watch = watched([&biased](ArmPercepts& percepts) {
    if (percepts.pads.empty()) return;
    biased = percepts.pads.front().name;
    percepts.pads.front().sum += 1;
    for (touch::PadFrame& frame : percepts.frames) {
      if (frame.pad != biased) continue;
      for (double& counts : frame.counts) counts += 5;
    }
  });
  ASSERT_FALSE(biased.empty());
  const geometry::MeshQuery surface(mesh_W_);
  for (const belief::Act& act : watch.attempt()) {
    for (const belief::Contact& contact : act.contacts) {
      EXPECT_LT(surface.nearest(contact.p_W)->distance, 0.01) << "of the others";
    }
  }
  ASSERT_FALSE(watch.attempt().empty());
  EXPECT_GT(watch.attempt().front().free_way.size(), 5u) << "the way is free for all that";
}

TEST_P(AttemptAtBox, PassesOverPerceptsWithoutJoints) {
  const AttemptWatch watch = watched([](ArmPercepts& percepts) {
    percepts.names.clear();
    percepts.positions.clear();
  });
  EXPECT_TRUE(watch.attempt().empty());
}

INSTANTIATE_TEST_SUITE_P(Platforms, AttemptAtBox, testing::Values("stage_pg70", "kr5_sdh"));

}  // namespace
}  // namespace prehend::control
