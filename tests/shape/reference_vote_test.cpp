#include "tests/oracles/reference_vote.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

constexpr double kVoteDegree = std::numbers::pi / 180;

/// A camera at the origin of W that looks along +z; the table is y = 0.1 with normal -y.
SyntheticView empty_view() {
  SyntheticView view;
  view.camera = {32, 24, 100, 100, 15.5, 11.5};
  view.mask = geometry::MaskImage(32, 24, 0);
  view.X_WC = geometry::RigidTransform::Identity();
  view.table_W = {-Eigen::Vector3d::UnitY(), -0.1};
  return view;
}

/// Adds the point that pixel (u, v) sees at depth z, and the pixel to the mask.
void see(SyntheticView& view, int u, int v, double z) {
  view.mask.at(u, v) = 255;
  view.cloud_W.points.push_back(view.camera.unproject(u, v, z).cast<float>());
}

TEST(ReferenceVote, DistanceTransformAndNearestDepth) {
  SyntheticView view = empty_view();
  see(view, 10, 10, 0.5);
  see(view, 14, 10, 0.7);
  view.mask.at(12, 10) = 255;  // equally near to both: the lesser depth
  view.mask.at(13, 10) = 255;
  const SeenImages images = reference_images(view.view());
  EXPECT_EQ(images.distance.at(12, 10), 0);
  EXPECT_DOUBLE_EQ(images.distance.at(7, 6), 5);  // 3-4-5
  EXPECT_DOUBLE_EQ(images.distance.at(14, 9), 1);
  EXPECT_NEAR(images.depth.at(12, 10), 0.5, 1e-7);
  EXPECT_NEAR(images.depth.at(13, 10), 0.7, 1e-7);
}

TEST(ReferenceVote, OfSeveralPointsInAPixelTheNearestCounts) {
  SyntheticView view = empty_view();
  see(view, 10, 10, 0.7);
  see(view, 10, 10, 0.5);
  EXPECT_NEAR(reference_images(view.view()).depth.at(10, 10), 0.5, 1e-7);
}

// One seen point at depth 0.5 m; planes z = const move it along its ray's neighbourhood.
TEST(ReferenceVote, EachCaseOfEquationThree) {
  SyntheticView view = empty_view();
  for (int v = 0; v < 24; ++v) {
    for (int u = 8; u < 24; ++u) view.mask.at(u, v) = 255;
  }
  view.cloud_W.points.emplace_back(0.f, 0.f, 0.5f);
  const SeenImages images = reference_images(view.view());
  const VoteOptions options;
  const auto tally = [&](const Eigen::Vector3d& normal, double offset) {
    return reference_tally(view.view(), images, {normal, offset}, options);
  };
  // (ii) 0.1 m behind the seen surface.
  const VoteTally hidden = tally(Eigen::Vector3d::UnitZ(), 0.55);
  EXPECT_EQ(hidden.hidden, 1);
  EXPECT_EQ(hidden.published_vote(), 0);
  EXPECT_EQ(hidden.contradicted, 0);
  // (iii) 0.1 m before it.
  const VoteTally before = tally(Eigen::Vector3d::UnitZ(), 0.45);
  EXPECT_NEAR(before.in_front, 0.1 - options.depth_tolerance, 1e-7);
  EXPECT_EQ(before.contradicted, 1);
  EXPECT_EQ(before.hidden, 0);
  // (iii) beside the mask: 0.06 m to the right is pixel 15.5 + 12 = 27.5, rounded 28; the mask ends
  // at 23, so 5 - 1/2 pixels of 5 mm.
  const VoteTally outside = tally(Eigen::Vector3d::UnitX(), 0.03);
  EXPECT_EQ(outside.outside_points, 1);
  EXPECT_EQ(outside.outside_pixels, 25);
  EXPECT_NEAR(outside.outside_squared, std::pow(4.5 * 0.5 / 100, 2), 1e-9);
  EXPECT_EQ(outside.contradicted, 1);
  // (i) moved along the surface by 2 cm: coincides. Not moved: says nothing.
  EXPECT_NEAR(tally(Eigen::Vector3d::UnitX(), 0.01).coincident, 1, 1e-4);
  EXPECT_EQ(tally(Eigen::Vector3d::UnitX(), 0.002).coincident, 0);
  // Nobody looked there: behind the camera, and beside the image.
  EXPECT_EQ(tally(Eigen::Vector3d::UnitZ(), -0.1).unseen, 1);
  EXPECT_EQ(tally(Eigen::Vector3d::UnitX(), 0.2).unseen, 1);
  EXPECT_EQ(tally(Eigen::Vector3d::UnitX(), 0.2).published_vote(), 0);
}

// Squared distances, and two expectations over their own points each: not one mean of plain
// distances over the whole cloud, as it once was.
TEST(ReferenceVote, AddsTwoExpectationsOverTheirOwnPoints) {
  SyntheticView view = empty_view();
  for (int v = 0; v < 24; ++v) {
    for (int u = 4; u < 24; ++u) view.mask.at(u, v) = 255;
  }
  const SeenImages images = [&] {
    SyntheticView wall = view;  // seen all over at 0.5 m
    for (int v = 0; v < 24; ++v) {
      for (int u = 4; u < 24; ++u) {
        wall.cloud_W.points.push_back(view.camera.unproject(u, v, 0.5).cast<float>());
      }
    }
    return reference_images(wall.view());
  }();
  // Mirrored at x = 0, pixel u goes to 31 - u: 3 and 0 end 5 and 8 pixels beside the mask, at
  // 28 and 31; 10 and 16 stay within.
  const geometry::Plane plane{Eigen::Vector3d::UnitX(), 0};
  const auto add = [&](int u, double z) {
    view.cloud_W.points.push_back(view.camera.unproject(u, 12, z).cast<float>());
  };
  add(3, 0.5);
  add(0, 0.5);
  VoteTally tally = reference_tally(view.view(), images, plane, {});
  EXPECT_NEAR(tally.published_vote(), (25. + 64.) / 2, 1e-9);
  add(10, 0.49);                             // 10 mm nearer than what it hides
  add(16, 0.48);                             // 20 mm
  add(12, 0.499);                            // 1 mm: within our tolerance, which the paper has not
  for (int u = 8; u < 20; ++u) add(u, 0.7);  // hidden: in neither expectation
  tally = reference_tally(view.view(), images, plane, {});
  EXPECT_EQ(tally.outside_points, 2);
  EXPECT_EQ(tally.nearer_points, 3);
  EXPECT_EQ(tally.hidden, 12);
  EXPECT_NEAR(tally.nearer, 0.031, 1e-6);
  EXPECT_NEAR(tally.published_vote(), 89. / 2 + 0.031 / 3 / kPublishedDepthUnit, 1e-3);
}

TEST(ReferenceVote, StartsAlongTheEigenvectorMostPerpendicularToTheView) {
  for (const double yaw : {0.0, 15.0, -30.0}) {
    // 15 cm across the view, 6 cm along it: the plane's trace is across.
    const SyntheticView view = synthetic_view(
        standing(geometry::make_box({0.06, 0.15, 0.05}), yaw * kVoteDegree), {.width = 160});
    const StartingPlane start = reference_start(view.view());
    EXPECT_NEAR(start.normal_W.z(), 0, 1e-9);
    EXPECT_LT(start.normal_W.x(), 0);  // away from the camera at +x
    EXPECT_NEAR(start.normal_W.norm(), 1, 1e-12);
    EXPECT_LT(std::abs(std::atan2(start.normal_W.y(), -start.normal_W.x()) + yaw * kVoteDegree),
              12 * kVoteDegree);
  }
}

TEST(ReferenceVote, ThirtyFiveHypothesesOfThePaper) {
  const SyntheticView view =
      synthetic_view(standing(geometry::make_box({0.06, 0.15, 0.05}), 0), {.width = 160});
  const auto planes = reference_hypotheses(view.view(), 7, 5, 20 * kVoteDegree);
  ASSERT_EQ(planes.size(), 35u);
  const StartingPlane start = reference_start(view.view());
  const Eigen::Vector3d center_C = view.X_WC.inverse() * start.center_W;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const Eigen::Vector3d normal_W = view.X_WC.linear() * planes[k].normal;
    EXPECT_NEAR(normal_W.z(), 0, 1e-12);
    const double angle = std::abs(static_cast<double>(k / 5) - 3) * 20 / 3 * kVoteDegree;
    EXPECT_NEAR(normal_W.dot(start.normal_W), std::cos(angle), 1e-9);
    EXPECT_NEAR(planes[k].signed_distance(center_C) == 0, k % 5 == 0, 0);
    EXPECT_LE(planes[k].signed_distance(center_C), 1e-12);  // away from the viewer
  }
}

TEST(ReferenceVote, LeastForTheTrueOrientation) {
  const SyntheticView view = synthetic_view(
      standing(geometry::make_box({0.06, 0.15, 0.05}), 10 * kVoteDegree), {.width = 160});
  const auto planes = reference_hypotheses(view.view(), 7, 5, 20 * kVoteDegree);
  const auto votes = reference_votes(view.view(), planes, {});
  std::size_t best = 0;
  for (std::size_t k = 0; k < votes.size(); ++k) {
    if (votes[k].published_vote() < votes[best].published_vote()) best = k;
  }
  const Eigen::Vector3d normal_W = view.X_WC.linear() * planes[best].normal;
  EXPECT_GT(std::abs(normal_W.dot(
                Eigen::Vector3d(std::cos(10 * kVoteDegree), std::sin(10 * kVoteDegree), 0))),
            std::cos(8 * kVoteDegree));
}

}  // namespace
}  // namespace prehend::shape
