// What is far from everyday: sizes, meshes, frictions; closure of very many grasps.

#include <cmath>
#include <cstdlib>
#include <limits>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/grasp/planner.h"
#include "prehend/grasp/wrench/wrench_hull.h"
#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using geometry::TriangleMesh;

const RigidTransform kHere = RigidTransform::Identity();

PlannerOptions few() {
  PlannerOptions options = default_options(TestHand("sdh2").model);
  options.candidates.circles.directions_per_circle = 4;
  options.candidates.circles.rolls = 2;
  options.candidates.circles.standoffs = 2;
  options.largest_count = 4;
  options.further_generators.clear();
  return options;
}

/// Plans with both hands; every candidate must be accounted for and every grasp be one. Returns the
/// number of grasps.
int plan_both(const TriangleMesh& mesh, double friction = -1) {
  surface::ObjectModel object;
  object.mesh_W = moved(mesh, Vector3d(0, 0, -geometry::bounds(mesh).min().z()));
  int grasps = 0;
  for (const char* name : {"sdh2", "bh8"}) {
    robot::HandModel model = robot::read_hand_model(std::string("config/robots/") + name + ".yaml");
    if (friction >= 0) model.friction = friction;
    const HandToClose hand(model);
    const GraspPlan plan = plan_grasps(object, geometry::Plane{}, {}, hand, {}, few());
    int counted = static_cast<int>(plan.grasps.size());
    for (const Rejection& rejection : plan.rejections) counted += rejection.count;
    EXPECT_EQ(counted, plan.candidates) << name;
    EXPECT_EQ(plan.grasps.empty(), !plan.problem.empty()) << name;
    for (const Grasp& grasp : plan.grasps) {
      EXPECT_TRUE(std::isfinite(grasp.score) && grasp.score > 0) << name;
      EXPECT_GT(grasp.quality, 0) << name;
      EXPECT_TRUE(grasp.closed_all.allFinite()) << name;
      EXPECT_LE(grasp.effort, 1) << name;
    }
    grasps += static_cast<int>(plan.grasps.size());
  }
  return grasps;
}

/// A box without its top: not closed.
TriangleMesh open_box(const Vector3d& size) {
  TriangleMesh box = geometry::make_box(size), result;
  result.vertices = box.vertices;
  for (const auto& t : box.triangles) {
    const Vector3d normal = (box.vertices[static_cast<std::size_t>(t[1])] -
                             box.vertices[static_cast<std::size_t>(t[0])])
                                .cross(box.vertices[static_cast<std::size_t>(t[2])] -
                                       box.vertices[static_cast<std::size_t>(t[0])]);
    if (normal.normalized().z() < 0.9) result.triangles.push_back(t);
  }
  return result;
}

TEST(HandExtremes, SizesFromASpeckToAWardrobe) {
  EXPECT_EQ(plan_both(geometry::make_box({1.0, 0.6, 2.0})), 0);
  plan_both(geometry::make_box({0.002, 0.002, 0.002}));  // smaller than a texel
  // A plate that stands, and one that lies: fingers of 28 mm cannot get under that.
  EXPECT_GT(plan_both(geometry::make_box({0.12, 0.001, 0.12})), 0);
  EXPECT_EQ(plan_both(geometry::make_box({0.3, 0.3, 0.001})), 0);
  // A needle that stands.
  plan_both(geometry::make_revolution({{0.0005, 0}, {0.0005, 0.15}}, 8));
}

TEST(HandExtremes, ShapesThatAreNotConvex) {
  EXPECT_GT(plan_both(make_torus(0.05, 0.015, 48, 16)), 0);
  EXPECT_GT(plan_both(geometry::concatenated(
                {geometry::make_box({0.04, 0.04, 0.12}),
                 moved(geometry::make_box({0.08, 0.03, 0.03}), Vector3d(0.06, 0, 0.03))})),
            0);
}

TEST(HandExtremes, MeshesThatAreNotSolids) {
  EXPECT_GT(plan_both(open_box({0.05, 0.06, 0.1})), 0);
  TriangleMesh degenerate = geometry::make_box({0.05, 0.06, 0.1});
  degenerate.triangles.emplace_back(0, 0, 1);
  degenerate.triangles.emplace_back(2, 2, 2);
  degenerate.vertices.push_back(0.5 * (degenerate.vertices[0] + degenerate.vertices[1]));
  degenerate.triangles.emplace_back(0, 1, 8);  // three in a line
  EXPECT_GT(plan_both(degenerate), 0);
  TriangleMesh inside_out = geometry::make_box({0.05, 0.06, 0.1});
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_GT(plan_both(inside_out), 0);
  TriangleMesh undefined = geometry::make_box({0.05, 0.06, 0.1});
  undefined.vertices[3].x() = std::nan("");
  surface::ObjectModel object;
  object.mesh_W = undefined;
  const TestHand hand("sdh2");
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, hand.ready, {}, few()),
               geometry::InputError);
}

TEST(HandExtremes, FrictionOfNoneAndOfTwo) {
  const TriangleMesh carton = geometry::make_box({0.05, 0.06, 0.1});
  EXPECT_EQ(plan_both(carton, 0), 0);  // six faces, but never seven contacts
  EXPECT_GT(plan_both(carton, 2), 0);
}

TEST(HandExtremes, AMillionTrianglesCloseAsAFewThousandDo) {
  const TestHand sdh("sdh2");
  const TriangleMesh fine = moved(geometry::make_sphere(0.03, 1000), {0, 0, 0.22});
  ASSERT_GT(fine.triangles.size(), 900000u);
  const TouchedMesh million(fine);
  const TouchedMesh thousands(moved(geometry::make_sphere(0.03, 100), {0, 0, 0.22}));
  for (const char* preshape : {"tripod", "spherical"}) {
    const ClosedFingers a = sdh.close(preshape, kHere, million.scene);
    const ClosedFingers b = sdh.close(preshape, kHere, thousands.scene);
    EXPECT_LT((a.all - b.all).cwiseAbs().maxCoeff(), 2e-3) << preshape;
    EXPECT_EQ(a.contacts.size(), b.contacts.size()) << preshape;
  }
}

TEST(HandExtremes, ANeedleIsFeltWhereverItStands) {
  const TestHand sdh("sdh2");
  for (int i = 0; i < 12; ++i) {
    const Vector3d at(-0.0095, 0.028 + 0.0009 * i, 0.19);  // before finger 1 of the parallel hand
    const TouchedMesh needle(
        moved(geometry::make_revolution({{0.0003, 0}, {0.0003, 0.06}}, 6), at));
    const ClosedFingers closed = sdh.close("parallel", kHere, needle.scene);
    EXPECT_TRUE(closed.finger_touches[0]) << i;
    const double face =
        0.01905 - 0.0148 - 0.0865 * std::sin(sdh.position(closed, "finger_1_proximal"));
    EXPECT_NEAR(face, -0.0095 + 0.0003, 6e-4) << i;
  }
}

TEST(HandExtremes, ClosingDoesNotDependOnWhereInTheWorld) {
  const TestHand sdh("sdh2"), barrett("bh8");
  std::mt19937_64 random(4);
  const TriangleMesh ball = moved(geometry::make_sphere(0.035, 60), {0, 0, 0.17});
  const TouchedMesh here(ball);
  for (int i = 0; i < 6; ++i) {
    RigidTransform X = random_turn(random);
    X.translation() = 0.5 * Vector3d(random_unit(random), random_unit(random), 1);
    const TouchedMesh there(moved(ball, X));
    for (const TestHand* one : {&sdh, &barrett}) {
      const TestHand& hand = *one;
      const std::string preshape = hand.model.name == "sdh2" ? "spherical" : "spread_60";
      const ClosedFingers a = hand.close(preshape, kHere, here.scene);
      const ClosedFingers b = hand.close(preshape, X, there.scene);
      EXPECT_LT((a.all - b.all).cwiseAbs().maxCoeff(), 5e-3) << hand.model.name;
      EXPECT_EQ(a.finger_touches, b.finger_touches);
    }
  }
}

// ---- closure

std::vector<Contact> random_grasp(std::mt19937_64& random, int contacts) {
  std::vector<Contact> grasp;
  const auto vector = [&random] {
    const double x = random_unit(random), y = random_unit(random);
    return Vector3d(x, y, random_unit(random));
  };
  for (int i = 0; i < contacts; ++i) {
    const Vector3d out = vector().normalized();
    Contact contact;
    contact.point = 0.04 * (out + 0.2 * vector());
    contact.normal = (-out + 0.4 * vector()).normalized();
    contact.friction = 0.1 + 0.45 * (1 + random_unit(random));
    contact.torsion_radius = random() % 2 == 0 ? 0 : 0.01;
    grasp.push_back(contact);
  }
  return grasp;
}

// 10 000 here; PREHEND_RANDOM_GRASPS=100000 takes a minute.
TEST(RandomGrasps, ClosureIsTheLinearProgrammes) {
  const char* asked = std::getenv("PREHEND_RANDOM_GRASPS");
  const int count = asked != nullptr ? std::atoi(asked) : 10000;
  ASSERT_GT(count, 0);
  std::mt19937_64 random(20);
  int closed = 0, doubtful = 0, wrong = 0;
  for (int n = 0; n < count; ++n) {
    const auto grasp = random_grasp(random, 2 + n % 4);
    const Wrenches w = primitive_wrenches(grasp, Vector3d::Zero(), 0.04, 6);
    const WrenchHull hull = wrench_hull(w, {.closure_only = true});
    const ForceClosure programme =
        evaluate_force_closure(grasp, Vector3d::Zero(), 0.04, {.cone_edges = 6});
    closed += hull.closed;
    if (hull.closed == programme.closed) {
      if (hull.closed && !may_be_closed(w)) ++wrong;
      continue;
    }
    // Within rounding of the border.
    if (std::abs(programme.margin) < 1e-5 || (hull.distance > 0 && hull.distance < 1e-8)) {
      ++doubtful;
    } else {
      ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(doubtful, count / 2000);
  EXPECT_GT(closed, count / 10);
  EXPECT_LT(closed, 9 * count / 10);
}

TEST(RandomGrasps, ClosureAndEpsilonAreThoseOfAMovedAndScaledGrasp) {
  std::mt19937_64 random(21);
  int closed = 0;
  for (int n = 0; n < 150; ++n) {
    const auto grasp = random_grasp(random, 3 + n % 3);
    const WrenchHull hull = wrench_hull(primitive_wrenches(grasp, Vector3d::Zero(), 0.04, 8));
    const Vector3d by(3 * random_unit(random), random_unit(random), 2);
    // Moved and scaled: the same numbers.
    for (const double scale : {0.01, 30.0}) {
      auto other = grasp;
      for (Contact& contact : other) {
        contact.point = scale * (contact.point + by);
        contact.torsion_radius *= scale;
      }
      const WrenchHull same = wrench_hull(primitive_wrenches(other, scale * by, scale * 0.04, 8));
      ASSERT_EQ(same.closed, hull.closed) << n;
      EXPECT_NEAR(same.epsilon, hull.epsilon, 1e-8) << n;
    }
    // Turned: the cones' edges are turned about their normals, which is at most what a polygon of
    // 8 edges is smaller than its circle.
    const RigidTransform X = random_turn(random);
    auto turned = grasp;
    for (Contact& contact : turned) {
      contact.point = X * contact.point;
      contact.normal = X.linear() * contact.normal;
    }
    const WrenchHull other = wrench_hull(primitive_wrenches(turned, Vector3d::Zero(), 0.04, 8));
    if (hull.epsilon > 0.02) {
      EXPECT_TRUE(other.closed) << n;
    }
    EXPECT_NEAR(other.epsilon, hull.epsilon, 0.03 + 0.1 * hull.epsilon) << n;
    closed += hull.closed;
  }
  EXPECT_GT(closed, 30);
}

}  // namespace
}  // namespace prehend::grasp
