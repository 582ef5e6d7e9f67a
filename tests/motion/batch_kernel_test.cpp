// Many positions at once against one at a time.

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "prehend/motion/nearest_kernel.h"
#include "tests/motion/pick_scene.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using robot::Positions;

/// A scene with obstacles of every kind, and something held.
RobotInWorld crowded(const PickScene& scene, std::mt19937_64& random, double margin) {
  CollisionWorld world = scene.world;
  const auto point = [&random] {
    const double x = robot::uniform(random), y = robot::uniform(random);
    return Vector3d(2 * x - 1, 2 * y - 1, 0.2 + robot::uniform(random));
  };
  for (int i = 0; i < 6; ++i) {
    const Vector3d p = point(), size = 0.05 * (Vector3d::Ones() + point().cwiseAbs());
    geometry::RigidTransform X = at(p.x(), p.y(), p.z());
    X.rotate(Eigen::AngleAxisd(p.x(), point().normalized()));
    world.add_box("box", X, size);
    world.add_sphere("ball", point(), 0.03 + 0.1 * robot::uniform(random));
    world.add_convex("piece", geometry::transformed(geometry::make_sphere(0.08, 8),
                                                    at(point().x(), point().y(), point().z())));
  }
  world.add_plane("wall", {Vector3d(1, 0.2, 0).normalized(), -0.9});
  world.set_margin("ball", Part::kHand, -0.02);
  world.set_margin("box", Part::kHeld, -std::numeric_limits<double>::infinity());
  RobotInWorld robot(scene.chain, make_robot_spheres(scene.model, "base_link", "grip", 0.05), world,
                     margin);
  std::vector<RobotSphere> held;
  for (const Ball& ball : scene.task.object.cover_O.balls) {
    held.push_back({-1, ball.center, ball.radius});
  }
  robot.attach(held);
  return robot;
}

TEST(NotFree, AgreesWithOneAtATimeButForRounding) {
  std::mt19937_64 random(1);
  for (const char* arm : {"kr5", "pa10"}) {
    const PickScene scene(arm, {0.6, 0.2, 0});
    int touching = 0, free = 0, close = 0;
    for (int world = 0; world < 8; ++world) {
      std::mt19937_64 same(static_cast<std::uint64_t>(world)), again = same, once_more = same;
      const RobotInWorld robot = crowded(scene, same, 0.005);
      // The same with margins a little smaller and larger: between them either answer is right.
      const RobotInWorld smaller = crowded(scene, again, 0.005 - 3e-6);
      const RobotInWorld larger = crowded(scene, once_more, 0.005 + 3e-6);
      for (int n = 0; n < 400; ++n) {
        std::array<Positions, kBatch> q;
        const int count = 1 + n % kBatch;
        for (Positions& one : q) {
          one = robot::random_positions(scene.chain, random);
          if (robot::uniform(random) < 0.05) one[2] += 7;  // beyond the limits
        }
        const std::uint32_t mask = robot.not_free(q.data(), count);
        EXPECT_EQ(mask >> count, 0u);
        for (int i = 0; i < count; ++i) {
          const bool ours = (mask >> i) & 1u;
          const Positions& one = q[static_cast<std::size_t>(i)];
          if (smaller.is_free(one) != larger.is_free(one)) {
            ++close;
            continue;
          }
          ASSERT_EQ(ours, !robot.is_free(one)) << arm << " " << world << " " << n << " " << i;
          (ours ? touching : free) += 1;
        }
      }
    }
    EXPECT_GT(touching, 1000);
    EXPECT_GT(free, 300);
    EXPECT_LT(close, 20);
  }
}

TEST(NotFree, NeverCallsFreeWhatTouches) {
  // A ball moved through the margin in steps of a tenth of a micrometre.
  const PickScene scene("pa10", {0.6, 0.2, 0});
  const Positions q = Positions::Constant(7, 0.3);
  CollisionWorld world;
  const RobotSpheres spheres = make_robot_spheres(scene.model, "base_link", "grip", 0.05);
  RobotInWorld robot(scene.chain, spheres, world, 0.005);
  std::vector<Vector3d> centers;
  spheres.centers(scene.chain, q, centers);
  const Vector3d direction = Vector3d(1, -1, 0.5).normalized();
  const double contact = spheres.spheres.back().radius + 0.05 + 0.005;
  int both = 0;
  for (int i = -60; i <= 60; ++i) {
    const Vector3d p = centers.back() + (contact + 1e-7 * i) * direction;
    robot.change_world([&p](CollisionWorld& w) {
      w.remove("ball");
      w.add_sphere("ball", p, 0.05);
    });
    const bool batch = robot.not_free(&q, 1) != 0, one = !robot.is_free(q);
    EXPECT_TRUE(batch || !one) << i;
    EXPECT_TRUE(!batch || one || i <= 20) << i;  // early by 2 um at most
    both += batch && one;
  }
  EXPECT_GT(both, 40);
}

TEST(NotFree, CarriesAPrismaticJointAndRefusesBadCounts) {
  // The KR5 on a rail along y, for which one joint is a length.
  robot::RobotModel model = robot::read_urdf("config/robots/kr5_sixx_r850.urdf");
  model.joints.front().kind = robot::Joint::Kind::kPrismatic;
  model.joints.front().axis_J = Vector3d(0, 0.6, 0.8);
  model.joints.front().lower = -1;
  model.joints.front().upper = 1;
  const robot::KinematicChain chain(model, "base_link", "tool0");
  CollisionWorld world;
  world.add_sphere("ball", {0.5, 0.3, 0.6}, 0.3);
  const RobotInWorld robot(chain, make_robot_spheres(model, "base_link", "tool0"), world);
  std::mt19937_64 random(3);
  int touching = 0;
  for (int n = 0; n < 500; ++n) {
    const Positions q = robot::random_positions(chain, random);
    const bool ours = robot.not_free(&q, 1) != 0;
    ASSERT_EQ(ours, !robot.is_free(q));
    touching += ours;
  }
  EXPECT_GT(touching, 50);
  EXPECT_LT(touching, 450);
  const Positions q = chain.middle();
  EXPECT_THROW(robot.not_free(&q, 0), std::invalid_argument);
  EXPECT_THROW(robot.not_free(&q, kBatch + 1), std::invalid_argument);
}

TEST(NearestPoint, IsTheFirstOfTheNearest) {
  std::mt19937_64 random(5);
  for (const std::size_t joints : {1u, 6u, 7u, 16u}) {
    for (const std::size_t count : {1u, 7u, 8u, 9u, 100u}) {
      std::vector<float> blocks((count + kBatch - 1) / kBatch * kBatch * joints, 1e15f);
      const auto number = [&](std::size_t point, std::size_t j) -> float& {
        return blocks[point / kBatch * kBatch * joints + j * kBatch + point % kBatch];
      };
      // On a coarse grid, so that several are as near.
      for (std::size_t point = 0; point < count; ++point) {
        for (std::size_t j = 0; j < joints; ++j) {
          number(point, j) = std::floor(4 * static_cast<float>(robot::uniform(random)));
        }
      }
      for (int n = 0; n < 50; ++n) {
        std::vector<float> q(joints);
        for (float& one : q) one = std::floor(4 * static_cast<float>(robot::uniform(random)));
        std::size_t best = 0;
        float least = std::numeric_limits<float>::infinity();
        for (std::size_t point = 0; point < count; ++point) {
          float sum = 0;
          for (std::size_t j = 0; j < joints; ++j) {
            sum += (number(point, j) - q[j]) * (number(point, j) - q[j]);
          }
          if (sum >= least) continue;
          least = sum;
          best = point;
        }
        ASSERT_EQ(nearest_point(blocks.data(), count, q.data(), joints), best);
      }
    }
  }
}

TEST(IsFreeBetween, TestsEveryStep) {
  // A thin obstacle at each of the steps in turn is found; none is where nothing is.
  const PickScene scene("kr5", {0.6, 0.2, 0});
  const RobotSpheres spheres = make_robot_spheres(scene.model, "base_link", "grip", 0.05);
  Positions from = Positions::Zero(6), to = from;
  from << -1, -1, 0.5, 0, 0.5, 0;
  to = from;
  to[0] = 1;
  for (const int steps : {1, 2, 7, 8, 9, 40}) {
    for (int at_step = 0; at_step <= steps; ++at_step) {
      const Positions q = from + (to - from) * (static_cast<double>(at_step) / steps);
      CollisionWorld world;
      std::vector<Vector3d> centers;
      spheres.centers(scene.chain, q, centers);
      world.add_sphere("pin", centers.back(), 1e-4);
      const RobotInWorld robot(scene.chain, spheres, world, 0);
      EXPECT_FALSE(robot.is_free_between(from, to, 2.0 / steps + 1e-9));
    }
    const RobotInWorld robot(scene.chain, spheres, CollisionWorld(), 0);
    EXPECT_TRUE(robot.is_free_between(from, to, 2.0 / steps + 1e-9));
  }
}

/// The same robot with balls that are larger or smaller.
RobotInWorld with_balls(const RobotInWorld& robot, double larger) {
  RobotSpheres spheres = robot.spheres();
  for (RobotSphere& ball : spheres.spheres) ball.radius = std::max(1e-6, ball.radius + larger);
  return {robot.chain(), spheres, robot.world(), 0};
}

TEST(IsSweptFree, IsWhatDenseStepsSay) {
  // Thin rods that steps jump over, and a wrist that folds onto the arm.
  const PickScene scene("pa10", {0.6, 0.2, 0});
  const RobotSpheres spheres = make_robot_spheres(scene.model, "base_link", "grip", 0.05);
  CollisionWorld world = scene.world;
  for (int i = 0; i < 12; ++i) {
    world.add_box("rod", at(0.7 * std::cos(i), 0.7 * std::sin(i), 0.8), {0.004, 0.004, 1.6});
    world.add_sphere("ball", {0.9 * std::cos(i + 0.5), 0.9 * std::sin(i + 0.5), 0.4}, 0.01);
  }
  const RobotInWorld robot(scene.chain, spheres, world, 0);
  // Between tested positions balls may touch by their spare, and what is refused touches, at a
  // position that is at most half a millimetre from one that is tested here.
  const RobotInWorld smaller = with_balls(robot, -kBallSpare), larger = with_balls(robot, 1e-3);
  const auto touches = [](const RobotInWorld& one, const Positions& from, const Positions& to) {
    for (int i = 0; i <= 1000; ++i) {
      if (!one.is_free(from + i / 1000.0 * (to - from))) return true;
    }
    return false;
  };
  std::mt19937_64 random(6);
  int swept = 0, refused = 0, jumped = 0;
  while (swept + refused < 300) {
    const Positions from = robot::random_positions(scene.chain, random);
    Positions to = from;
    for (int j = 0; j < to.size(); ++j) to[j] += 0.5 * (robot::uniform(random) - 0.5);
    if (!robot.is_free(from) || !robot.is_free(to)) continue;
    if (robot.is_swept_free(from, to)) {
      ++swept;
      EXPECT_FALSE(touches(smaller, from, to));
    } else {
      ++refused;
      EXPECT_TRUE(touches(larger, from, to));
      jumped += robot.is_free_between(from, to, 0.1);
    }
  }
  EXPECT_GT(swept, 50);
  EXPECT_GT(refused, 20);
  EXPECT_GT(jumped, 2);  // else the test shows nothing
}

}  // namespace
}  // namespace prehend::motion
