#include "prehend/grasp/generators/candidates.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/robot/gripper_model.h"

namespace prehend::grasp {
namespace {

using geometry::TriangleMesh;

TriangleMesh placed(const TriangleMesh& mesh, const Eigen::Quaterniond& q,
                    const Eigen::Vector3d& p) {
  return geometry::transformed(mesh, geometry::make_transform(q, p));
}

std::vector<Candidate> sample(const TriangleMesh& mesh, const Reachability& reachability = {},
                              const CandidateOptions& options = {}) {
  return sample_candidates(mesh, geometry::mass_properties(mesh).center_of_mass, geometry::Plane{},
                           robot::GripperModel{}.tip_z(), reachability, options);
}

TEST(PrincipalAxes, OfABox) {
  const Eigen::Matrix3d axes = principal_axes(geometry::make_box({0.05, 0.2, 0.1}));
  EXPECT_NEAR(std::abs(axes(1, 0)), 1, 1e-9);
  EXPECT_NEAR(std::abs(axes(2, 1)), 1, 1e-9);
  EXPECT_NEAR(axes.determinant(), 1, 1e-9);
}

TEST(SmallestWidth, OfRectangleTriangleAndDegenerate) {
  const auto rectangle = smallest_width({{0, 0}, {3, 0}, {3, 1}, {0, 1}, {1.5, 0.5}});
  EXPECT_NEAR(rectangle.width, 1, 1e-12);
  EXPECT_NEAR(std::abs(rectangle.direction.y()), 1, 1e-12);
  // The least width of a triangle is its least height.
  EXPECT_NEAR(smallest_width({{0, 0}, {4, 0}, {0, 3}}).width, 2.4, 1e-12);
  EXPECT_EQ(smallest_width({{1, 1}}).width, 0);
  EXPECT_NEAR(smallest_width({{0, 0}, {1, 1}, {2, 2}}).width, 0, 1e-12);
}

// However the object lies, the vertical approach is among the samples, exactly.
TEST(SampleCandidates, AlwaysHoldsTheVerticalApproach) {
  const TriangleMesh box = geometry::make_box({0.05, 0.08, 0.2});
  for (double tilt : {0.0, 0.2, 0.7, 1.5707963267948966}) {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(tilt, Eigen::Vector3d(1, 0.3, 0).normalized()));
    const auto candidates = sample(placed(box, q, {0.4, 0.1, 0.12}));
    const auto vertical =
        std::count_if(candidates.begin(), candidates.end(), [](const Candidate& c) {
          return (c.approach_W + Eigen::Vector3d::UnitZ()).norm() < 1e-12;
        });
    EXPECT_EQ(vertical, 12 * 6 * 3) << tilt;
  }
}

TEST(SampleCandidates, DirectionsLieOnTwoPerpendicularCircles) {
  const TriangleMesh box =
      placed(geometry::make_box({0.05, 0.08, 0.2}),
             Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX())), {0, 0, 0.2});
  const Eigen::Vector3d major = principal_axes(box).col(0);
  const Eigen::Vector3d normal = major.cross(Eigen::Vector3d::UnitZ()).normalized();
  for (const auto& c : sample(box)) {
    const double about = std::abs(c.approach_W.dot(major));
    const double containing = std::abs(c.approach_W.dot(normal));
    EXPECT_LT(std::min(about, containing), 1e-9);
  }
}

TEST(SampleCandidates, PoseAgreesWithItsParameters) {
  const TriangleMesh box = placed(geometry::make_box({0.05, 0.04, 0.1}),
                                  Eigen::Quaterniond::Identity(), {0.3, -0.2, 0.05});
  const Eigen::Vector3d centroid(0.3, -0.2, 0.05);
  const robot::GripperModel gripper;
  for (const auto& c : sample(box)) {
    EXPECT_NEAR((c.X_WG.linear().col(2) - c.approach_W).norm(), 0, 1e-12);
    EXPECT_NEAR(c.X_WG.linear().determinant(), 1, 1e-9);
    const Eigen::Vector3d tip = c.X_WG * Eigen::Vector3d(0, 0, gripper.tip_z());
    EXPECT_NEAR(c.approach_W.dot(centroid - tip), c.standoff, 1e-9);
    EXPECT_NEAR(c.X_WG.linear().col(0).dot(c.X_WG.translation() - centroid), c.lateral_offset,
                1e-9);
    EXPECT_NEAR(c.X_WG.linear().col(1).dot(c.X_WG.translation() - centroid), 0, 1e-9);
  }
}

TEST(SampleCandidates, RollZeroClosesAlongTheSmallestWidth) {
  const double yaw = 0.37;
  const Eigen::Quaterniond q(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  for (const auto& c : sample(placed(geometry::make_box({0.08, 0.04, 0.1}), q, {0, 0, 0.05}))) {
    if (c.roll != 0 || c.approach_W.z() > -0.999) continue;
    EXPECT_NEAR(std::abs(c.X_WG.linear().col(1).dot(q * Eigen::Vector3d::UnitY())), 1, 1e-9);
  }
}

TEST(SampleCandidates, FixedApproachIsAmongTheSamples) {
  Reachability reachability;
  reachability.approach_W = Eigen::Vector3d(0.1, 0.2, -1).normalized();
  const auto candidates = sample(
      placed(geometry::make_box({0.05, 0.04, 0.1}), Eigen::Quaterniond::Identity(), {0, 0, 0.05}),
      reachability);
  EXPECT_TRUE(std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return (c.approach_W - *reachability.approach_W).norm() < 1e-12;
  }));
}

TEST(SampleCandidates, RejectsNonsense) {
  CandidateOptions options;
  options.rolls = 0;
  EXPECT_THROW(sample(geometry::make_box({1, 1, 1}), {}, options), std::invalid_argument);
  options = {};
  options.lateral_offsets.clear();
  EXPECT_THROW(sample(geometry::make_box({1, 1, 1}), {}, options), std::invalid_argument);
}

TEST(Reachability, DefaultReachesEverything) {
  Reachability all;
  EXPECT_TRUE(all.reaches_direction(Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(all.reaches_point({100, 0, 0}));
  all.approach_W = -Eigen::Vector3d::UnitZ();
  all.workspace_W = Eigen::AlignedBox3d(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1));
  EXPECT_TRUE(all.reaches_direction({0.01, 0, -1}));
  EXPECT_FALSE(all.reaches_direction({0.1, 0, -1}));
  EXPECT_FALSE(all.reaches_direction({0, 0, 1}));
  EXPECT_FALSE(all.reaches_point({100, 0, 0}));
}

}  // namespace
}  // namespace prehend::grasp
