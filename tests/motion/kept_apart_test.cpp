// Which parts of a robot never touch: against closed forms, against positions all over the limits,
// and against the same robot that tests all pairs.

#include "prehend/motion/kept_apart.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/platform.h"
#include "tests/robot/arms.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

struct Turn {
  double x;             // m, of its axis from the one before
  double lower, upper;  // rad; m for a slide
  std::string axis = "0 0 1";
  std::string type = "revolute";
};

robot::KinematicChain chain_of(const std::vector<Turn>& turns) {
  std::string links = "<link name=\"l0\"/>", joints;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const Turn& turn = turns[i];
    links += fmt::format("<link name=\"l{}\"/>", i + 1);
    const std::string limit =
        turn.type == "continuous"
            ? ""
            : fmt::format(R"(<limit lower="{}" upper="{}" effort="1" velocity="1"/>)", turn.lower,
                          turn.upper);
    joints +=
        fmt::format(R"(<joint name="j{0}" type="{1}"><parent link="l{0}"/><child link="l{2}"/>)"
                    R"(<origin xyz="{3} 0 0"/><axis xyz="{4}"/>{5}</joint>)",
                    i, turn.type, i + 1, turn.x, turn.axis, limit);
  }
  const robot::RobotModel model =
      robot::parse_urdf("<robot name=\"r\">" + links + joints + "</robot>", "test");
  return {model, "l0", fmt::format("l{}", turns.size())};
}

RobotSphere ball(int joint, const Vector3d& p_J, double radius) { return {joint, p_J, radius}; }

TEST(KeptApart, TellsTheReachOfTwoLinks) {
  // Lengths 0.3 and 0.2: the tip comes to all that is 0.1 to 0.5 m from the base.
  const robot::KinematicChain chain = chain_of({{0, -kPi, kPi}, {0.3, -kPi, kPi}});
  const RobotSphere tip = ball(1, {0.2, 0, 0}, 0.01);
  for (const double angle : {0.0, 1.0, 2.0, 3.0, 4.5}) {
    const Vector3d direction(std::cos(angle), std::sin(angle), 0);
    EXPECT_TRUE(are_kept_apart(chain, ball(-1, 0.05 * direction, 0.03), tip));
    EXPECT_FALSE(are_kept_apart(chain, ball(-1, 0.05 * direction, 0.05), tip));
    EXPECT_TRUE(are_kept_apart(chain, ball(-1, 0.6 * direction, 0.08), tip));
    EXPECT_FALSE(are_kept_apart(chain, ball(-1, 0.6 * direction, 0.1), tip));
    EXPECT_FALSE(are_kept_apart(chain, ball(-1, 0.3 * direction, 0.01), tip));
  }
  // Whichever comes first.
  EXPECT_TRUE(are_kept_apart(chain, tip, ball(-1, {0.6, 0, 0}, 0.08)));
  EXPECT_FALSE(are_kept_apart(chain, tip, ball(-1, {0.6, 0, 0}, 0.1)));
}

TEST(KeptApart, LimitsCountAndALittleBeyondThem) {
  // One joint: a ball on a circle of 1 m, from a ball that it would meet at 1 rad.
  const auto apart = [](double upper) {
    return are_kept_apart(chain_of({{0, -1, upper}}),
                          ball(-1, {std::cos(1.0), std::sin(1.0), 0}, 0.001),
                          ball(0, {1, 0, 0}, 0.001));
  };
  EXPECT_FALSE(apart(1));
  EXPECT_FALSE(apart(1 - kPastLimits));
  EXPECT_TRUE(apart(1 - kPastLimits - 0.01));
  // A slide of 0.1 m towards what is 0.3 m away.
  const auto slides = [](double to) {
    return are_kept_apart(chain_of({{0, 0, 0.1, "1 0 0", "prismatic"}}), ball(-1, {to, 0, 0}, 0.05),
                          ball(0, {0, 0, 0}, 0.05));
  };
  EXPECT_TRUE(slides(0.3));
  EXPECT_FALSE(slides(0.2 + kPastLimits - 0.001));
}

TEST(KeptApart, NothingIsProvenOfWhatHasNoBoundOrNoNumber) {
  const double infinite = std::numeric_limits<double>::infinity(),
               none = std::numeric_limits<double>::quiet_NaN();
  const robot::KinematicChain one = chain_of({{0, -1, 1}});
  EXPECT_FALSE(are_kept_apart(one, ball(0, {1, 0, 0}, 0.1), ball(0, {3, 0, 0}, 0.1)));
  EXPECT_FALSE(are_kept_apart(one, ball(-1, {none, 0, 0}, 0.1), ball(0, {3, 0, 0}, 0.1)));
  EXPECT_FALSE(are_kept_apart(one, ball(-1, {0, 0, 0}, none), ball(0, {3, 0, 0}, 0.1)));
  EXPECT_FALSE(are_kept_apart(one, ball(-1, {0, 0, 0}, infinite), ball(0, {3, 0, 0}, 0.1)));
  // What turns without limits turns once round.
  const robot::KinematicChain turns =
      chain_of({{0, 0, 0, "0 0 1", "continuous"}, {0.3, 0, 0, "0 0 1", "continuous"}});
  EXPECT_TRUE(are_kept_apart(turns, ball(-1, {0.6, 0, 0}, 0.08), ball(1, {0.2, 0, 0}, 0.01)));
  EXPECT_FALSE(are_kept_apart(turns, ball(-1, {0, 0.45, 0}, 0.01), ball(1, {0.2, 0, 0}, 0.01)));
}

TEST(KeptApart, NoPositionContradictsAProof) {
  std::mt19937_64 random(3);
  int proven = 0, touching = 0;
  for (int n = 0; n < 300; ++n) {
    const auto somewhere = [&] {
      return Vector3d(robot::uniform(random) - 0.5, robot::uniform(random) - 0.5,
                      robot::uniform(random) - 0.5);
    };
    std::vector<Turn> turns;
    const int joints = 1 + n % 4;
    for (int k = 0; k < joints; ++k) {
      const Vector3d axis = somewhere().normalized();
      const double lower = -3 * robot::uniform(random), upper = 3 * robot::uniform(random);
      const bool slides = robot::uniform(random) < 0.2;
      turns.push_back({0.3 * robot::uniform(random), slides ? 0.1 * lower : lower,
                       slides ? 0.1 * upper : upper,
                       fmt::format("{} {} {}", axis.x(), axis.y(), axis.z()),
                       slides ? "prismatic" : "revolute"});
    }
    const robot::KinematicChain chain = chain_of(turns);
    const RobotSphere a = ball(-1, somewhere(), 0.1 * robot::uniform(random)),
                      b = ball(joints - 1, somewhere(), 0.1 * robot::uniform(random));
    const bool apart = are_kept_apart(chain, a, b);
    RobotSpheres both{{a, b}, {}, {}};
    std::vector<Vector3d> centers;
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3000; ++i) {
      both.centers(chain, robot::random_positions(chain, random), centers);
      nearest = std::min(nearest, (centers[0] - centers[1]).norm());
    }
    proven += apart;
    touching += nearest < a.radius + b.radius;
    ASSERT_FALSE(apart && nearest < a.radius + b.radius) << n;
  }
  EXPECT_GT(proven, 50);
  EXPECT_GT(touching, 30);
}

/// A robot that tests what was proven, too.
RobotSpheres testing_all(RobotSpheres spheres) {
  spheres.self_pairs.insert(spheres.self_pairs.end(), spheres.apart_pairs.begin(),
                            spheres.apart_pairs.end());
  spheres.apart_pairs.clear();
  return spheres;
}

TEST(KeptApart, ARobotIsAsFreeAsOneThatTestsAllItsPairs) {
  int robots = 0, robots_with_some = 0;
  for (const auto& entry : std::filesystem::directory_iterator("config/robots")) {
    if (entry.path().extension() != ".yaml") continue;
    std::optional<robot::Platform> platform;
    try {
      platform = robot::read_platform(entry.path());
    } catch (const geometry::InputError&) {
      continue;  // a hand's file
    }
    SCOPED_TRACE(platform->name);
    const robot::RobotModel model =
        platform->with_hand_at(platform->hand.all_positions(platform->hand.preshapes.front().open));
    const RobotSpheres spheres = make_robot_spheres(model, platform->base, platform->flange, 0.04);
    ++robots;
    robots_with_some += !spheres.apart_pairs.empty();
    const robot::KinematicChain chain = platform->arm_chain();
    const RobotInWorld some(chain, spheres, CollisionWorld(), 0),
        all(chain, testing_all(spheres), CollisionWorld(), 0);
    std::mt19937_64 random(5);
    int free = 0;
    for (int n = 0; n < 4000; ++n) {
      robot::Positions q = robot::random_positions(chain, random);
      // Joints like to be nearest to each other at their ends.
      for (int k = 0; n % 2 && k < chain.size(); ++k) {
        const robot::ChainJoint& joint = chain.joints()[static_cast<std::size_t>(k)];
        const double share = robot::uniform(random);
        if (share < 0.25 && std::isfinite(joint.lower)) q[k] = joint.lower;
        if (share > 0.75 && std::isfinite(joint.upper)) q[k] = joint.upper;
      }
      ASSERT_EQ(some.problem(q), all.problem(q)) << q.transpose();
      ASSERT_EQ(some.not_free(&q, 1), all.not_free(&q, 1)) << q.transpose();
      free += some.is_free(q);
    }
    EXPECT_GT(free, 100);
  }
  EXPECT_GE(robots, 9);
  EXPECT_GE(robots_with_some, 8);
}

TEST(KeptApart, WhatIsKeptIsOfTheSameRobotAlone) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  const auto spheres_at = [&](double share) {
    robot::RobotModel model =
        platform.with_hand_at(platform.hand.all_positions(platform.hand.preshapes.front().open));
    for (robot::Joint& joint : model.joints) {  // a robot of the same shapes and narrower limits
      joint.lower *= share;
      joint.upper *= share;
    }
    return make_robot_spheres(model, platform.base, platform.flange, 0.04);
  };
  const RobotSpheres first = spheres_at(1), again = spheres_at(1), narrow = spheres_at(0.3);
  EXPECT_EQ(first.apart_pairs, again.apart_pairs);
  EXPECT_EQ(first.self_pairs, again.self_pairs);
  EXPECT_GT(narrow.apart_pairs.size(), first.apart_pairs.size());
}

}  // namespace
}  // namespace prehend::motion
