#include "prehend/grasp/planner.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/solid.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

const geometry::Plane kTable{};

surface::ObjectModel standing(const geometry::TriangleMesh& mesh) {
  const double lowest = geometry::bounds(mesh).min().z();
  surface::ObjectModel object;
  object.mesh_W = moved(mesh, Vector3d(0, 0, -lowest));
  return object;
}

/// Few candidates, so that tests are quick.
PlannerOptions quick() {
  PlannerOptions options = default_options(TestHand("sdh2").model);
  options.candidates.circles.directions_per_circle = 6;
  options.candidates.circles.rolls = 3;
  options.candidates.circles.standoffs = 2;
  options.largest_count = 8;
  options.further_generators.clear();
  return options;
}

int counted(const GraspPlan& plan) {
  int sum = static_cast<int>(plan.grasps.size());
  for (const Rejection& rejection : plan.rejections) sum += rejection.count;
  return sum;
}

int count(const GraspPlan& plan, Reason reason) {
  int sum = 0;
  for (const Rejection& rejection : plan.rejections) {
    sum += rejection.reason == reason ? rejection.count : 0;
  }
  return sum;
}

/// What a grasp claims, by other means: exact distances, the linear programme.
void check_grasp(const TestHand& hand, const surface::ObjectModel& object, const Grasp& grasp,
                 const std::string& what) {
  const geometry::MeshQuery query(object.mesh_W);
  // On its way the open hand keeps clear; closed it enters neither object nor table.
  const Eigen::VectorXd open = hand.model.all_positions(grasp.open);
  const auto clearance = [&](const Eigen::VectorXd& all, double back, bool table) {
    std::vector<RigidTransform> poses;
    hand.model.link_poses(all, poses);
    double least = 1;
    for (std::size_t l = 0; l < poses.size(); ++l) {
      const LinkBalls& balls = hand.ready.balls.links[l];
      for (std::size_t b = 0; b < balls.centers.size(); b += table ? 1 : 7) {
        const Vector3d p = grasp.X_WH * (poses[l] * balls.centers[b]) - back * grasp.approach_W;
        const auto near = query.nearest(p, 0.03);
        least = std::min({least, kTable.signed_distance(p) - balls.radii[b],
                          near ? near->distance - balls.radii[b] : 1});
      }
    }
    return least;
  };
  for (int i = 0; i <= 10; ++i) {
    EXPECT_GT(clearance(open, grasp.pregrasp_distance * i / 10, false), 0.0012) << what;
  }
  EXPECT_GT(clearance(grasp.closed_all, 0, true), -4e-4) << what;
  EXPECT_EQ(hand.model.limit_problem(grasp.closed_all), "") << what;

  const Solid solid = make_solid(object.mesh_W, 800);
  std::vector<Contact> contacts;
  for (const GraspContact& contact : grasp.contacts) contacts.push_back(contact.contact_W);
  const ForceClosure closure =
      evaluate_force_closure(contacts, solid.center_of_mass_W, solid.radius);
  EXPECT_TRUE(closure.closed) << what;
  EXPECT_EQ(grasp.predicted.lifted_mass, solid.mass) << what;
  EXPECT_GT(grasp.quality, 0) << what;
  EXPECT_LE(grasp.quality, closure.quality + 1e-6) << what;
  EXPECT_LE(grasp.effort, 1) << what;
  EXPECT_GT(grasp.effort, 0) << what;
  EXPECT_GE(grasp.margin, 0) << what;
  EXPECT_GT(grasp.score, 0) << what;
  EXPECT_LE(grasp.score, 1) << what;
  for (int m = 0; m < hand.model.size(); ++m) {
    const auto& joint =
        hand.model.model
            .joints[static_cast<std::size_t>(hand.model.actuated[static_cast<std::size_t>(m)])];
    EXPECT_LE(std::abs(grasp.torques[m]), joint.max_effort * (1 + 1e-9)) << what;
  }
}

TEST(PlanHandGrasps, GraspsEverydayThingsAndEachClaimHolds) {
  const std::pair<const char*, geometry::TriangleMesh> things[] = {
      {"ball", geometry::make_sphere(0.035, 48)},
      {"carton", geometry::make_box({0.05, 0.07, 0.12})},
      {"can", geometry::make_revolution({{0.033, 0}, {0.033, 0.12}})},
      {"bar", geometry::make_box({0.15, 0.02, 0.03})}};
  for (const char* name : {"sdh2", "bh8"}) {
    const TestHand hand(name);
    for (const auto& [thing, mesh] : things) {
      const surface::ObjectModel object = standing(mesh);
      const GraspPlan plan = plan_grasps(object, kTable, {}, hand.ready, {}, quick());
      EXPECT_GE(plan.grasps.size(), 3u) << name << " " << thing << ": " << plan.problem;
      EXPECT_EQ(counted(plan), plan.candidates);
      EXPECT_EQ(plan.outcome, PlanOutcome::kGraspable);
      EXPECT_TRUE(plan.problem.empty());
      for (std::size_t i = 0; i < plan.grasps.size(); ++i) {
        check_grasp(hand, object, plan.grasps[i],
                    std::string(name) + " " + thing + " " + std::to_string(i));
        EXPECT_LE(plan.grasps[i].score, plan.grasps[i == 0 ? 0 : i - 1].score);
      }
    }
  }
}

bool equal(const GraspPlan& a, const GraspPlan& b) {
  if (a.grasps.size() != b.grasps.size() || a.rejections.size() != b.rejections.size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.grasps.size(); ++i) {
    if (a.grasps[i].score != b.grasps[i].score ||
        a.grasps[i].X_WH.matrix() != b.grasps[i].X_WH.matrix() ||
        a.grasps[i].closed_all != b.grasps[i].closed_all) {
      return false;
    }
  }
  for (std::size_t i = 0; i < a.rejections.size(); ++i) {
    if (a.rejections[i].count != b.rejections[i].count ||
        a.rejections[i].nearest_miss != b.rejections[i].nearest_miss) {
      return false;
    }
  }
  return true;
}

TEST(PlanHandGrasps, IsTheSameAgainAndInSeveralThreads) {
  const TestHand hand("sdh2");
  const surface::ObjectModel object = standing(geometry::make_box({0.04, 0.06, 0.1}));
  const auto plan = [&] { return plan_grasps(object, kTable, {}, hand.ready, {}, quick()); };
  const GraspPlan first = plan();
  GraspPlan others[2];
  std::thread one([&] { others[0] = plan(); }), two([&] { others[1] = plan(); });
  one.join();
  two.join();
  EXPECT_TRUE(equal(first, others[0]));
  EXPECT_TRUE(equal(first, others[1]));
  for (const int threads : {1, 2, 5}) {
    PlannerOptions options = quick();
    options.threads = threads;
    EXPECT_TRUE(equal(first, plan_grasps(object, kTable, {}, hand.ready, {}, options))) << threads;
  }
}

TEST(PlanHandGrasps, TheBestAreRankedByWhatHoldsInDisturbedPoses) {
  const TestHand hand("bh8");
  const surface::ObjectModel object = standing(geometry::make_sphere(0.04, 48));
  PlannerOptions options = quick();
  options.robust_count = 5;
  const auto robustness = [&](double position) {
    options.uncertainty.position_deviation = position;
    std::vector<double> all;
    for (const auto& grasp : plan_grasps(object, kTable, {}, hand.ready, {}, options).grasps) {
      if (grasp.robustness >= 0) all.push_back(grasp.robustness);
      EXPECT_LE(grasp.robustness, 1);
      if (options.uncertainty.samples == 0) continue;
      EXPECT_LE(grasp.score, 1 - options.robust_weight * (1 - std::max(0.0, grasp.robustness)));
    }
    return all;
  };
  options.uncertainty.rotation_deviation = 0;
  options.uncertainty.least_friction = options.uncertainty.largest_friction = hand.model.friction;
  const auto sure = robustness(0);
  ASSERT_EQ(sure.size(), 5u);
  EXPECT_EQ(*std::min_element(sure.begin(), sure.end()), 1);
  const auto usual = robustness(0.004), wild = robustness(0.03);
  ASSERT_EQ(wild.size(), 5u);
  EXPECT_GT(*std::max_element(usual.begin(), usual.end()),
            *std::max_element(wild.begin(), wild.end()));
  EXPECT_LT(*std::max_element(wild.begin(), wild.end()), 0.5);
  options.uncertainty.samples = 0;
  EXPECT_TRUE(robustness(0).empty());
}

TEST(PlanHandGrasps, OnceEnoughAreSureTheOthersAreNotTried) {
  for (const char* name : {"sdh2", "bh8"}) {
    const TestHand hand(name);
    const surface::ObjectModel object = standing(geometry::make_sphere(0.04, 48));
    PlannerOptions options = quick();
    options.largest_count = 3;
    options.enough_grasps = 2;
    options.uncertainty.position_deviation = 0.001;  // most hold in all of these
    options.uncertainty.rotation_deviation = 0.01;
    const GraspPlan enough = plan_grasps(object, kTable, {}, hand.ready, {}, options);
    options.enough_grasps = 0;
    const GraspPlan all = plan_grasps(object, kTable, {}, hand.ready, {}, options);
    EXPECT_EQ(enough.candidates, all.candidates) << name;
    EXPECT_EQ(counted(enough), enough.candidates) << name;
    EXPECT_EQ(count(all, Reason::kEnough), 0) << name;
    // Half of them at least, as shares are a quarter and a half.
    EXPECT_GE(2 * count(enough, Reason::kEnough), enough.candidates) << name;
    ASSERT_EQ(enough.grasps.size(), 3u) << name;
    EXPECT_GE(enough.grasps[1].robustness, PlannerOptions::kSure) << name;
    options.first_share = 1;
    options.enough_grasps = 2;
    EXPECT_TRUE(equal(plan_grasps(object, kTable, {}, hand.ready, {}, options), all)) << name;
    options.first_share = 16;
    const GraspPlan few = plan_grasps(object, kTable, {}, hand.ready, {}, options);
    EXPECT_GE(count(few, Reason::kEnough), count(enough, Reason::kEnough)) << name;
    EXPECT_EQ(counted(few), all.candidates) << name;
    options.enough_grasps = 0;
    options.largest_count = 10000;
    options.robust_count = 0;
    const GraspPlan whole = plan_grasps(object, kTable, {}, hand.ready, {}, options);
    for (const Grasp& grasp : enough.grasps) {
      EXPECT_TRUE(std::any_of(whole.grasps.begin(), whole.grasps.end(), [&](const Grasp& one) {
        return one.X_WG.isApprox(grasp.X_WG, 1e-2) && one.preshape == grasp.preshape;
      })) << name;
    }
  }
}

// The shares are a matter of time alone: what was known of them is asked once, and says the same.
TEST(PlanHandGrasps, WhereTooFewAreSureAllAreTriedAsIfAtOnce) {
  for (const char* name : {"sdh2", "bh8", "pg70"}) {
    const TestHand hand(name);
    surface::ObjectModel object = standing(geometry::make_box({0.05, 0.06, 0.1}));
    object.alternatives_W = {moved(object.mesh_W, {0.004, 0, 0})};
    PlannerOptions options = hand.model.gripper ? default_options(hand.model) : quick();
    options.uncertainty.position_deviation = 0.02;  // few hold in nine of ten of these
    options.enough_grasps = options.largest_count;
    options.first_share = 9;
    const GraspPlan shares = plan_grasps(object, kTable, {}, hand.ready, {}, options);
    EXPECT_EQ(count(shares, Reason::kEnough), 0) << name;
    options.enough_grasps = 0;
    const GraspPlan at_once = plan_grasps(object, kTable, {}, hand.ready, {}, options);
    ASSERT_FALSE(shares.grasps.empty()) << name;
    EXPECT_TRUE(equal(shares, at_once)) << name;
  }
}

TEST(PlanHandGrasps, FurtherGeneratorsAreTriedWhenNothingIsRobust) {
  const TestHand hand("bh8");
  const surface::ObjectModel object = standing(geometry::make_sphere(0.04, 48));
  PlannerOptions options = quick();
  options.candidates.samples = 5;
  options.further_generators = {"antipodal"};
  options.enough = 0;
  const GraspPlan first = plan_grasps(object, kTable, {}, hand.ready, {}, options);
  options.uncertainty.position_deviation = 0.03;  // nothing holds in all of these
  options.enough = 1;
  const GraspPlan both = plan_grasps(object, kTable, {}, hand.ready, {}, options);
  EXPECT_GT(both.candidates, first.candidates);
  EXPECT_EQ(counted(both), both.candidates);
  EXPECT_LE(static_cast<int>(both.grasps.size()), options.largest_count);
  const auto of_antipodal = [](const GraspPlan& plan) {
    return std::any_of(plan.rejections.begin(), plan.rejections.end(),
                       [](const Rejection& r) { return r.generator == "antipodal"; });
  };
  EXPECT_FALSE(of_antipodal(first));
  EXPECT_TRUE(of_antipodal(both));
}

TEST(PlanHandGrasps, ContactThatIsNotSureCostsScore) {
  const TestHand hand("bh8");
  surface::ObjectModel object = standing(geometry::make_sphere(0.04, 48));
  PlannerOptions options = quick();
  options.uncertainty.samples = 0;
  const auto sure = plan_grasps(object, kTable, {}, hand.ready, {}, options);
  object.vertex_origin.assign(object.mesh_W.vertices.size(), surface::SurfaceOrigin::kPredicted);
  object.vertex_confidence.assign(object.mesh_W.vertices.size(), 0.4F);
  const auto unsure = plan_grasps(object, kTable, {}, hand.ready, {}, options);
  ASSERT_FALSE(sure.grasps.empty());
  ASSERT_EQ(sure.grasps.size(), unsure.grasps.size());
  for (std::size_t i = 0; i < sure.grasps.size(); ++i) {
    EXPECT_NEAR(unsure.grasps[i].score, (1 - options.guessed_weight * 0.6) * sure.grasps[i].score,
                1e-6);
  }
}

// Else the hand pushes what it closes on.
TEST(Preshapes, FingersTowardsTheMiddleTouchABallAtOnce) {
  for (const auto& [name, preshape] :
       {std::pair("sdh2", "tripod"), {"sdh2", "spherical"}, {"bh8", "spread_60"}}) {
    const TestHand hand(name);
    const robot::Preshape& shape = hand.model.preshape(preshape);
    for (const double radius : {0.03, 0.04}) {
      const TouchedMesh ball(geometry::make_sphere(radius, 48));
      const ClosedFingers closed =
          hand.close(preshape, (hand.model.X_HP * shape.X_PG).inverse(), ball.scene);
      double least = 10, most = 0;  // rad, that each inner joint turned
      for (const robot::Finger& finger : hand.model.fingers) {
        for (int i = 0; i < hand.model.size(); ++i) {
          const int joint = hand.model.actuated[static_cast<std::size_t>(i)];
          const int child = hand.model.model.joints[static_cast<std::size_t>(joint)].child;
          const bool of_finger =
              std::find(finger.links.begin(), finger.links.end(), child) != finger.links.end();
          if (!of_finger || shape.closing[static_cast<std::size_t>(i)].rate != 1) continue;
          least = std::min(least, closed.all[joint] - shape.open[i]);
          most = std::max(most, closed.all[joint] - shape.open[i]);
        }
      }
      EXPECT_GT(least, 0.1) << name << " " << preshape;
      EXPECT_NEAR(least, most, 0.03) << name << " " << preshape << " " << radius;
    }
  }
}

TEST(PlanHandGrasps, SaysWhyThereIsNoGrasp) {
  const TestHand hand("sdh2");
  // Larger than the hand.
  const GraspPlan large = plan_grasps(standing(geometry::make_box({0.5, 0.5, 0.5})), kTable, {},
                                      hand.ready, {}, quick());
  EXPECT_TRUE(large.grasps.empty());
  EXPECT_EQ(large.outcome, PlanOutcome::kUngraspable);
  EXPECT_FALSE(large.problem.empty());
  EXPECT_EQ(counted(large), large.candidates);
  // Of osmium, a hundredweight.
  const surface::ObjectModel carton = standing(geometry::make_box({0.05, 0.07, 0.12}));
  PlannerOptions heavy = quick();
  heavy.density = 120000;
  const GraspPlan too_heavy = plan_grasps(carton, kTable, {}, hand.ready, {}, heavy);
  EXPECT_TRUE(too_heavy.grasps.empty());
  EXPECT_GT(count(too_heavy, Reason::kTooWeak), 0);
  // Walled in.
  Obstacles walls;
  for (const double side : {-1.0, 1.0}) {
    walls.meshes_W.push_back(
        moved(geometry::make_box({0.02, 0.5, 0.5}), Vector3d(0.05 * side, 0, 0.25)));
    walls.meshes_W.push_back(
        moved(geometry::make_box({0.5, 0.02, 0.5}), Vector3d(0, 0.06 * side, 0.25)));
  }
  const GraspPlan walled = plan_grasps(carton, kTable, walls, hand.ready, {}, quick());
  EXPECT_TRUE(walled.grasps.empty());
  EXPECT_GT(count(walled, Reason::kObstacle), 0);
  // A cloud of points in the way does the same as a mesh.
  Obstacles cloud;
  for (int i = -8; i <= 8; ++i) {
    for (int j = -8; j <= 8; ++j) cloud.cloud_W.points.emplace_back(0.02 * i, 0.02 * j, 0.2);
  }
  Reachability from_above;
  from_above.approach_W = -Vector3d::UnitZ();
  const GraspPlan under = plan_grasps(carton, kTable, cloud, hand.ready, from_above, quick());
  EXPECT_TRUE(under.grasps.empty());
  EXPECT_GT(count(under, Reason::kObstacle), 0);
  EXPECT_GT(count(under, Reason::kDirection), 0);
  // What is out of the hand's reach changes nothing, be it metres away.
  Obstacles beside, with_far;
  beside.meshes_W = {moved(geometry::make_box({0.05, 0.05, 0.3}), Vector3d(0.09, 0, 0.15))};
  with_far.meshes_W = {beside.meshes_W.front(),
                       moved(geometry::make_box({0.2, 0.2, 0.2}), Vector3d(3, 1, 0.1))};
  with_far.cloud_W.points = {{-4, 0, 0.1F}};
  const GraspPlan near_one = plan_grasps(carton, kTable, beside, hand.ready, {}, quick());
  const GraspPlan both = plan_grasps(carton, kTable, with_far, hand.ready, {}, quick());
  EXPECT_GT(count(near_one, Reason::kObstacle), 0);
  EXPECT_EQ(count(both, Reason::kObstacle), count(near_one, Reason::kObstacle));
  ASSERT_FALSE(near_one.grasps.empty());
  ASSERT_EQ(both.grasps.size(), near_one.grasps.size());
  for (std::size_t i = 0; i < both.grasps.size(); ++i) {
    EXPECT_EQ(both.grasps[i].X_WH.matrix(), near_one.grasps[i].X_WH.matrix());
    EXPECT_EQ(both.grasps[i].closed_all, near_one.grasps[i].closed_all);
  }
  // An arm that reaches nothing.
  PlannerOptions nowhere = quick();
  nowhere.reaches = [](const RigidTransform&) { return false; };
  const GraspPlan unreached = plan_grasps(carton, kTable, {}, hand.ready, {}, nowhere);
  EXPECT_TRUE(unreached.grasps.empty());
  EXPECT_GT(count(unreached, Reason::kArm), 0);
}

TEST(PlanHandGrasps, ContactOnGuessedSurfaceIsTold) {
  const TestHand hand("bh8");
  surface::ObjectModel object = standing(geometry::make_sphere(0.035, 48));
  for (const auto& v : object.mesh_W.vertices) {
    object.vertex_origin.push_back(v.x() > 0 ? surface::SurfaceOrigin::kSeen
                                             : surface::SurfaceOrigin::kPredicted);
  }
  const GraspPlan plan = plan_grasps(object, kTable, {}, hand.ready, {}, quick());
  ASSERT_FALSE(plan.grasps.empty());
  int told = 0;
  for (const Grasp& grasp : plan.grasps) {
    EXPECT_GE(grasp.guessed_contact, 0);
    EXPECT_LE(grasp.guessed_contact, 1 + 1e-12);
    EXPECT_EQ(grasp.remark.empty(), grasp.guessed_contact <= 0.005);
    told += static_cast<int>(!grasp.remark.empty());
  }
  EXPECT_GT(told, 0);
}

TEST(PlanHandGrasps, BudgetEndsItAndCountsTheRest) {
  const TestHand hand("sdh2");
  const surface::ObjectModel object = standing(geometry::make_box({0.04, 0.06, 0.1}));
  PlannerOptions options = quick();
  options.budget = 1e-9;
  const GraspPlan plan = plan_grasps(object, kTable, {}, hand.ready, {}, options);
  EXPECT_TRUE(plan.grasps.empty());
  EXPECT_EQ(count(plan, Reason::kNoTime), plan.candidates);
}

TEST(PlanHandGrasps, OptionsAndNamesAreChecked) {
  const TestHand hand("sdh2");
  const surface::ObjectModel object = standing(geometry::make_box({0.04, 0.06, 0.1}));
  const auto plan = [&](const auto& change) {
    PlannerOptions options = quick();
    change(options);
    return plan_grasps(object, kTable, {}, hand.ready, {}, options);
  };
  EXPECT_THROW(plan([](auto& o) { o.cone_edges = 2; }), std::invalid_argument);
  EXPECT_THROW(plan([](auto& o) { o.density = 0; }), std::invalid_argument);
  EXPECT_THROW(plan([](auto& o) { o.safety_factor = std::nan(""); }), std::invalid_argument);
  EXPECT_THROW(plan([](auto& o) { o.generators = {}; }), std::invalid_argument);
  EXPECT_THROW(plan([](auto& o) { o.generators = {"circle"}; }), std::invalid_argument);
  EXPECT_THROW(plan([](auto& o) { o.preshapes = {"sferical"}; }), geometry::InputError);
  const GraspPlan one = plan([](auto& o) { o.preshapes = {"cylindrical"}; });
  ASSERT_FALSE(one.grasps.empty());
  for (const Grasp& grasp : one.grasps) {
    EXPECT_EQ(grasp.preshape, "cylindrical");
    EXPECT_EQ(grasp.volume, 0);
  }
  const GraspPlan measured = plan([](auto& o) {
    o.preshapes = {"parallel"};
    o.fingers.volume = true;
    o.largest_count = 2;
  });
  ASSERT_FALSE(measured.grasps.empty());
  // A ball of radius epsilon is in the wrench space: pi^3 / 6 of its sixth power.
  for (const Grasp& grasp : measured.grasps) {
    EXPECT_GT(grasp.volume, 5.1677 * std::pow(grasp.quality, 6));
  }
  surface::ObjectModel nothing;
  EXPECT_THROW(plan_grasps(nothing, kTable, {}, hand.ready, {}, quick()), geometry::InputError);
}

}  // namespace
}  // namespace prehend::grasp
