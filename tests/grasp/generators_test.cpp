#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/grasp/ledger.h"
#include "prehend/grasp/planner.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::grasp {
namespace {

using geometry::TriangleMesh;

const robot::GripperModel kGeneratorGripper;
const std::vector<std::string> kGenerators =
    GeneratorRegistry(std::vector<std::filesystem::path>{}).names();

class Scene {
 public:
  explicit Scene(const TriangleMesh& mesh, const Reachability& reachability = {})
      : query_(mesh),
        target_{query_, geometry::mass_properties(mesh).center_of_mass, geometry::Plane{},
                hand_reach(kGeneratorGripper), reachability} {}
  std::vector<Candidate> generate(const std::string& name, const GeneratorOptions& options = {}) {
    return make_generator(name)->generate(target_, options);
  }

 private:
  geometry::MeshQuery query_;
  GraspTarget target_;
};

TriangleMesh raised(const TriangleMesh& mesh, double z) {
  return geometry::transformed(
      mesh, geometry::make_transform(Eigen::Quaterniond::Identity(), {0.3, 0.1, z}));
}

Reachability from_above() {
  Reachability reachability;
  reachability.approach_W = -Eigen::Vector3d::UnitZ();
  return reachability;
}

class EachGenerator : public testing::TestWithParam<std::string> {};

TEST_P(EachGenerator, MakesUsableFramesInTheSameOrder) {
  for (const auto& reachability : {Reachability{}, from_above()}) {
    Scene scene(raised(geometry::make_box({0.04, 0.06, 0.1}), 0.05), reachability);
    const auto first = scene.generate(GetParam()), second = scene.generate(GetParam());
    ASSERT_GT(first.size(), 10u);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      const auto& candidate = first[i];
      EXPECT_EQ(candidate.X_WG.matrix(), second[i].X_WG.matrix());
      const Eigen::Matrix3d R = candidate.X_WG.linear();
      EXPECT_NEAR((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 0, 1e-9);
      EXPECT_NEAR(R.determinant(), 1, 1e-9);
      EXPECT_NEAR((R.col(2) - candidate.approach_W).norm(), 0, 1e-9);
      // The standoff is from the fingertips to the centroid along the approach.
      const Eigen::Vector3d tip = candidate.X_WG * Eigen::Vector3d(0, 0, kGeneratorGripper.tip_z());
      const Eigen::Vector3d centroid(0.3, 0.1, 0.05);
      EXPECT_NEAR((centroid - tip).dot(candidate.approach_W), candidate.standoff, 1e-9);
      if (reachability.approach_W && GetParam() != "circles") {
        EXPECT_TRUE(reachability.reaches_direction(candidate.approach_W));
        EXPECT_GE(tip.z(), 0.0049);
      }
    }
  }
}

TEST_P(EachGenerator, FindsGraspsOfABoxABallAndACan) {
  PlannerOptions options;
  options.generators = {GetParam()};
  options.uncertainty.samples = 0;
  for (const auto& [mesh, height] :
       {std::pair(geometry::make_box({0.04, 0.06, 0.1}), 0.05),
        std::pair(geometry::make_sphere(0.03), 0.03),
        std::pair(geometry::make_revolution({{0.03, -0.05}, {0.03, 0.05}}), 0.05)}) {
    surface::ObjectModel object;
    object.mesh_W = raised(mesh, height);
    const auto result =
        plan_grasps(object, geometry::Plane{}, {}, kGeneratorGripper, from_above(), options);
    EXPECT_FALSE(result.grasps.empty()) << result.problem;
    if (!result.grasps.empty()) {
      EXPECT_EQ(result.grasps.front().generator, GetParam());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EachGenerator, testing::ValuesIn(kGenerators),
                         [](const auto& test) { return test.param; });

TEST(Generators, AntipodalPointsAreInBothCones) {
  // On a ball the line between antipodal points passes within sin(atan(mu)) r of the middle.
  const double radius = 0.03;
  GeneratorOptions options;
  options.friction = 0.3;
  Scene scene(raised(geometry::make_sphere(radius, 128), 0.1));
  const auto candidates = scene.generate("antipodal", options);
  ASSERT_GT(candidates.size(), 100u);
  for (const auto& candidate : candidates) {
    const Eigen::Vector3d y = candidate.X_WG.linear().col(1);
    const Eigen::Vector3d to_middle = Eigen::Vector3d(0.3, 0.1, 0.1) - candidate.X_WG.translation();
    const Eigen::Vector3d x = candidate.X_WG.linear().col(0);
    EXPECT_LT(std::abs(to_middle.dot(x)), radius * std::sin(std::atan(0.3)) + 1e-3);
    EXPECT_NEAR(y.norm(), 1, 1e-9);
    EXPECT_LE(candidate.outline_width, 2 * radius + 1e-9);
    EXPECT_GE(candidate.outline_width, 2 * radius * std::cos(std::atan(0.3)) - 1e-3);
  }
}

TEST(Generators, MedialBallsOfAnEllipticCylinderCloseAcrossIt) {
  // A flat bar: balls inside touch its two large faces, 20 mm apart, unless near an edge.
  Scene scene(raised(geometry::make_box({0.02, 0.1, 0.16}), 0.08));
  const auto candidates = scene.generate("medial_axis");
  ASSERT_GT(candidates.size(), 100u);
  for (const auto& candidate : candidates) {
    EXPECT_NEAR(candidate.outline_width, 0.02, 1e-4);
    EXPECT_NEAR(std::abs(candidate.X_WG.linear().col(1).x()), 1, 1e-3);
  }
}

TEST(Generators, SegmentsCrossTheLongAxis) {
  Scene scene(raised(geometry::make_box({0.03, 0.04, 0.2}), 0.1));
  GeneratorOptions options;
  options.rolls = 2;
  for (const auto& candidate : scene.generate("segments", options)) {
    EXPECT_NEAR(candidate.X_WG.linear().col(1).z(), 0, 1e-6);
    EXPECT_TRUE(std::abs(candidate.outline_width - 0.03) < 1e-6 ||
                std::abs(candidate.outline_width - 0.04) < 1e-6);
  }
}

TEST(Generators, BoxRaysApproachAgainstTheSurface) {
  Scene scene(raised(geometry::make_box({0.03, 0.04, 0.2}), 0.1));
  for (const auto& candidate : scene.generate("boxes")) {
    EXPECT_NEAR(candidate.approach_W.cwiseAbs().maxCoeff(), 1, 1e-6);
  }
}

TEST(Generators, NothingToHoldGivesNoCandidates) {
  // A disc of 0.1 mm, smaller than any contact: no crash, poses that the planner can refuse.
  Scene scene(raised(geometry::make_revolution({{5e-5, 0}, {5e-5, 1e-6}}, 8), 0.001));
  for (const auto& name : kGenerators) {
    for (const auto& candidate : scene.generate(name)) {
      EXPECT_TRUE(candidate.X_WG.matrix().allFinite()) << name;
    }
  }
}

TEST(Generators, UnknownNameIsToldTheNearest) {
  try {
    make_generator("antipodel");
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("nearest is 'antipodal'"), std::string::npos)
        << error.what();
  }
}

TEST(Generators, OptionsOutOfRangeAreRefused) {
  PlannerOptions options;
  options.candidates.samples = 0;
  EXPECT_THROW(options.validate(), std::invalid_argument);
}

TEST(Ledger, KeepsTheNearestMiss) {
  Ledger ledger;
  ledger.reject(Reason::kTooWide, "circles", Miss{Miss::Quantity::kLength, 0.094, 0.069});
  ledger.reject(Reason::kTooWide, "circles", Miss{Miss::Quantity::kLength, 0.074, 0.069});
  ledger.reject(Reason::kTooWide, "circles");
  ledger.reject(Reason::kTooWide, "boxes");
  ledger.reject(Reason::kTurns, "circles", Miss{Miss::Quantity::kAngle, 0.2, 0.1});
  const auto rejections = ledger.rejections();
  ASSERT_EQ(rejections.size(), 3u);
  EXPECT_EQ(rejections[0].nearest_miss, "74.0 mm > 69.0 mm");
  EXPECT_EQ(rejections[0].count, 3);
  EXPECT_EQ(rejections[1].nearest_miss, "");
  EXPECT_EQ(rejections[2].nearest_miss, "11.5 deg > 5.7 deg");
  constexpr std::array kTested{Reason::kTurns, Reason::kTooWide};
  ledger.reject(Reason::kNoTime, "circles");
  const auto ordered = ledger.rejections(kTested);
  ASSERT_EQ(ordered.size(), 4u);
  EXPECT_EQ(ordered[0].reason, Reason::kTurns);
  EXPECT_EQ(ordered[1].generator, "circles");
  EXPECT_EQ(ordered[2].generator, "boxes");
  EXPECT_EQ(ordered[3].reason, Reason::kNoTime);
  EXPECT_EQ(ledger.count(Reason::kTooWide), 4);
  EXPECT_EQ(ledger.total(), 6);
  EXPECT_EQ(to_text({Miss::Quantity::kLength, -0.0032, 0.004}), "-3.2 mm < 4.0 mm");
  // It was "30.0 mm > 30.0 mm".
  EXPECT_EQ(to_text({Miss::Quantity::kLength, 0.03002, 0.03}), "30.02 mm > 30.00 mm");
}

}  // namespace
}  // namespace prehend::grasp
