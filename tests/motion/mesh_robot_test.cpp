// Robots whose links are meshes, against the same with primitives, and foreign ones.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/motion/rrt_connect.h"
#include "tests/motion/fcl_oracle.h"
#include "tests/robot/arms.h"
#include "tests/robot/as_meshes.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;

struct MeshFolder {
  MeshFolder()
      : path(std::filesystem::temp_directory_path() /
             ("prehend_mesh_robot_" + std::to_string(getpid()))) {}
  ~MeshFolder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

/// Whether a ball that moves with the arm meets one of the world.
bool meets(const RobotSpheres& spheres, const std::vector<Vector3d>& centers,
           const CollisionWorld& world) {
  for (std::size_t i = 0; i < centers.size(); ++i) {
    if (spheres.spheres[i].joint < 0) continue;  // the oracle has what the joints move
    if (world.clearance(centers[i], spheres.spheres[i].radius) < 0) return true;
  }
  return false;
}

TEST(MeshRobot, IsAsFreeAsItsPrimitivesUpToTheOvershoot) {
  const MeshFolder folder;
  const robot::RobotModel primitives = robot::read_urdf("config/robots/kr5_sixx_r850.urdf");
  const robot::RobotModel meshes =
      robot::read_urdf(robot::write_with_meshes("kr5_sixx_r850.urdf", folder.path));
  EXPECT_TRUE(meshes.remarks.empty());
  const robot::KinematicChain chain = robot::kr5();
  constexpr double kFacets = 0.0005;  // m: 48 facets lie beneath a round face by up to 0.26 mm
  for (const double resolution : {0.03, 0.06}) {
    std::mt19937_64 random(7);
    const RobotSpheres spheres = make_robot_spheres(meshes, "base_link", "tool0", resolution);
    CollisionWorld world;
    FclOracle less(primitives, chain), more(primitives, chain);
    for (int i = 0; i < 8; ++i) {
      const Vector3d p(robot::uniform(random) * 1.6 - 0.8, robot::uniform(random) * 1.6 - 0.8,
                       robot::uniform(random) * 1.2);
      const double radius = 0.02 + 0.06 * robot::uniform(random);
      world.add_sphere("s", p, radius);
      less.add_sphere(p, radius - kFacets);
      more.add_sphere(p, radius + resolution / 5 + kBallSpare);
    }
    int met = 0, free = 0;
    std::vector<Vector3d> centers;
    for (int n = 0; n < 3000; ++n) {
      const robot::Positions q = robot::random_positions(chain, random);
      spheres.centers(chain, q, centers);
      const bool ours = meets(spheres, centers, world);
      if (less.collides(chain, q)) {
        ++met;
        ASSERT_TRUE(ours) << "missed at " << q.transpose();
      }
      if (!more.collides(chain, q)) {
        ++free;
        ASSERT_FALSE(ours) << "farther than the overshoot at " << q.transpose();
      }
    }
    EXPECT_GT(met, 100);
    EXPECT_GT(free, 100);
  }
}

TEST(MeshRobot, StandsFreeOfItselfWhereThePrimitivesDo) {
  const MeshFolder folder;
  const robot::RobotModel primitives = robot::read_urdf("config/robots/kr5_sixx_r850.urdf");
  const robot::RobotModel meshes =
      robot::read_urdf(robot::write_with_meshes("kr5_sixx_r850.urdf", folder.path));
  const robot::KinematicChain chain = robot::kr5();
  CollisionWorld table;
  table.add_plane("table", {Vector3d::UnitZ(), -0.02});
  const RobotInWorld a(chain, make_robot_spheres(primitives, "base_link", "tool0"), table),
      b(chain, make_robot_spheres(meshes, "base_link", "tool0"), table);
  std::mt19937_64 random(8);
  // Balls round the thick primitives reach farther than those round meshes.
  int free = 0, both = 0;
  for (int n = 0; n < 2000; ++n) {
    const robot::Positions q = robot::random_positions(chain, random);
    if (!a.is_free(q)) continue;
    ++free;
    both += b.is_free(q);
  }
  EXPECT_GT(free, 500);
  EXPECT_GT(both, 0.9 * free);
  robot::Positions home(6);
  home << 0, -M_PI / 2, M_PI / 2, 0, M_PI / 2, 0;
  EXPECT_EQ(b.problem(home), "");
}

TEST(MeshRobot, AForeignArmFindsItsWay) {
  const char* data = std::getenv("PREHEND_SHARED_DATA");
  const std::filesystem::path file =
      std::filesystem::path(data ? data : "") / "robots/kuka_iiwa/model.urdf";
  if (!data || !std::filesystem::exists(file)) {
    GTEST_SKIP() << "PREHEND_SHARED_DATA names no folder with robots/kuka_iiwa/model.urdf, a robot "
                    "that is not part of this project";
  }
  const robot::RobotModel iiwa = robot::read_urdf(file);
  const robot::KinematicChain chain(iiwa, "lbr_iiwa_link_0", "lbr_iiwa_link_7");
  ASSERT_EQ(chain.size(), 7);
  CollisionWorld world;
  world.add_plane("table", {Vector3d::UnitZ(), -0.02});
  world.add_box("post", geometry::RigidTransform(Eigen::Translation3d(0.55, 0, 0.5)),
                {0.1, 0.1, 1.0});
  const RobotInWorld robot(chain, make_robot_spheres(iiwa, "lbr_iiwa_link_0", "lbr_iiwa_link_7"),
                           world);
  robot::Positions start = robot::Positions::Zero(7), goal = start;
  start << -1.2, 0.9, 0, -1.2, 0, 0.8, 0;
  goal << 1.2, 0.9, 0, -1.2, 0, 0.8, 0;
  ASSERT_EQ(robot.problem(start), "");
  ASSERT_EQ(robot.problem(goal), "");
  EXPECT_FALSE(robot.is_free_between(start, goal, 0.02)) << "the post is in the way";
  const JointPath path = plan_path(robot, start, {goal});
  ASSERT_TRUE(path.found()) << path.reason;
  for (std::size_t i = 1; i < path.waypoints.size(); ++i) {
    EXPECT_TRUE(robot.is_free_between(path.waypoints[i - 1], path.waypoints[i], 0.005));
  }
}

}  // namespace
}  // namespace prehend::motion
