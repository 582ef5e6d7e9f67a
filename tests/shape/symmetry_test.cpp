#include "prehend/shape/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "tests/oracles/reference_vote.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

constexpr double kPlaneDegree = 0.017453292519943295;

/// Distances of the mirrored points to the true surface [m], ascending.
std::vector<double> mirrored_errors(const CompletedShape& shape,
                                    const geometry::TriangleMesh& truth) {
  const geometry::MeshQuery query(truth);
  std::vector<double> errors;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    if (shape.origin[i] == PointOrigin::kSeen) continue;
    errors.push_back(query.nearest(shape.cloud_W.points[i].cast<double>())->distance);
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

/// Greatest distance from points of the truth to the nearest completed point [m].
double greatest_gap(const CompletedShape& shape, const std::vector<Eigen::Vector3d>& truth) {
  double greatest = 0;
  for (const Eigen::Vector3d& p : truth) {
    double least = 1e9;
    for (const Eigen::Vector3f& q : shape.cloud_W.points) {
      least = std::min(least, (q.cast<double>() - p).squaredNorm());
    }
    greatest = std::max(greatest, std::sqrt(least));
  }
  return greatest;
}

struct Solid {
  std::string name;
  geometry::TriangleMesh mesh;
};

Solid box_solid() { return {"box", geometry::make_box({0.06, 0.09, 0.12})}; }
Solid square_box() { return {"square_box", geometry::make_box({0.06, 0.06, 0.15})}; }
Solid long_box() { return {"long_box", geometry::make_box({0.15, 0.06, 0.08})}; }
Solid cylinder() {
  return {"cylinder", geometry::make_revolution({{0.035, 0}, {0.035, 0.1}}, 128)};
}

struct Case {
  Solid solid;
  double elevation;  // deg
  double yaw;        // deg
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.solid.name << "_elevation_" << c.elevation << "_yaw_" << c.yaw;
}

std::vector<Case> cases() {
  std::vector<Case> result;
  for (const Solid& solid : {box_solid(), square_box(), long_box(), cylinder()}) {
    for (const double elevation : {35.0, 42.0, 50.0}) {
      for (const double yaw : {0.0, 20.0, 45.0, 70.0, 90.0}) {
        result.push_back({solid, elevation, yaw});
      }
    }
  }
  return result;
}

class CutByTheView : public testing::TestWithParam<Case> {};

TEST_P(CutByTheView, IsCompletedWithinTwoMillimetres) {
  const auto& [solid, elevation, yaw] = GetParam();
  const geometry::TriangleMesh truth = standing(solid.mesh, yaw * kPlaneDegree, 0.1, 0.05);
  const SyntheticView view = synthetic_view(truth, {.elevation = elevation * kPlaneDegree});
  const CompletedShape shape = complete_by_symmetry(view.view());
  const std::vector<double> errors = mirrored_errors(shape, truth);
  ASSERT_GT(errors.size(), view.cloud_W.size() / 2);
  EXPECT_LT(errors.back(), 0.002);
}

TEST_P(CutByTheView, StaysWithinThreeMillimetresUnderOneMillimetreOfNoise) {
  const auto& [solid, elevation, yaw] = GetParam();
  const geometry::TriangleMesh truth = standing(solid.mesh, yaw * kPlaneDegree, 0.1, 0.05);
  const SyntheticView view = synthetic_view(
      truth, {.elevation = elevation * kPlaneDegree, .depth_noise = 0.001, .seed = 7});
  const CompletedShape shape = complete_by_symmetry(view.view());
  const std::vector<double> errors = mirrored_errors(shape, truth);
  ASSERT_GT(errors.size(), view.cloud_W.size() / 2);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.003);
  EXPECT_LT(errors[errors.size() / 2], 0.0015);
}

INSTANTIATE_TEST_SUITE_P(Solids, CutByTheView, testing::ValuesIn(cases()),
                         testing::PrintToStringParamName());

TEST(Symmetry, ASquareBoxHasAnAlternativeThatIsRightToo) {
  const geometry::TriangleMesh truth = standing(square_box().mesh, 20 * kPlaneDegree);
  const SyntheticView view = synthetic_view(truth, {});
  CompletionOptions options;
  EXPECT_TRUE(complete_by_symmetry(view.view(), options).alternatives.empty());
  options.alternatives = 2;
  const CompletedShape shape = complete_by_symmetry(view.view(), options);
  ASSERT_FALSE(shape.alternatives.empty());
  ASSERT_LE(shape.alternatives.size(), 2u);
  // Faces and diagonals of its footprint are planes of symmetry.
  const CompletedShape& other = shape.alternatives.front();
  EXPECT_LT(std::abs(other.symmetry.normal_W.dot(shape.symmetry.normal_W)), std::cos(0.3));
  EXPECT_LE(other.symmetry.vote, shape.symmetry.vote + options.alternative_vote);
  EXPECT_LT(mirrored_errors(other, truth).back(), 0.002);
  EXPECT_TRUE(other.alternatives.empty());
  for (std::size_t i = 0; i < view.cloud_W.size(); ++i) {
    ASSERT_EQ(other.cloud_W.points[i], view.cloud_W.points[i]);
  }
  EXPECT_EQ(other.point_confidence.size(), other.cloud_W.size());
}

// A cylinder that stands is a surface of revolution as well, and what it is below it is above.
TEST(Symmetry, OtherMethodsComeBesideOtherPlanes) {
  const SyntheticView view =
      synthetic_view(standing(geometry::make_revolution({{0.04, 0}, {0.04, 0.12}}), 0), {});
  CompletionOptions options;
  options.alternatives = 1;
  const std::size_t planes = complete_by_symmetry(view.view(), options).alternatives.size();
  options.other_methods = true;
  const CompletedShape shape = complete_by_symmetry(view.view(), options);
  ASSERT_EQ(shape.method, CompletionMethod::kMirror);
  EXPECT_EQ(shape.alternatives.size(), planes);
  ASSERT_FALSE(shape.other_methods.empty());
  bool has_rotation = false;
  for (const CompletedShape& other : shape.other_methods) {
    EXPECT_EQ(other.origin.size(), other.cloud_W.size());
    EXPECT_EQ(other.point_confidence.size(), other.cloud_W.size());
    EXPECT_TRUE(other.alternatives.empty());
    EXPECT_TRUE(std::equal(view.cloud_W.points.begin(), view.cloud_W.points.end(),
                           other.cloud_W.points.begin()));
    has_rotation = has_rotation || other.method == CompletionMethod::kRotation;
  }
  EXPECT_TRUE(has_rotation);
}

// Seen from above, what lies shows nothing of its underside: it is mirrored at the level half way
// up.
TEST(Symmetry, WhatLiesMayBeBelowAsAbove) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto lying =
      standing(geometry::transformed(geometry::make_revolution({{0.04, 0}, {0.04, 0.12}}), X), 0);
  const SyntheticView view = synthetic_view(lying, {});
  CompletionOptions options;
  options.other_methods = true;
  const CompletedShape shape = complete_by_symmetry(view.view(), options);
  const auto below = std::find_if(
      shape.other_methods.begin(), shape.other_methods.end(), [](const CompletedShape& other) {
        return other.second_symmetry && std::abs(other.second_symmetry->normal_W.z()) > 0.99;
      });
  ASSERT_NE(below, shape.other_methods.end());
  EXPECT_NEAR(below->second_symmetry->point_W.z(), 0.04, 0.001);
  const std::vector<double> errors = mirrored_errors(*below, lying);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.003);
  const auto lowest = [](const CompletedShape& one) {
    float z = 1;
    for (std::size_t i = 0; i < one.cloud_W.size(); ++i) {
      if (one.origin[i] != PointOrigin::kSeen) z = std::min(z, one.cloud_W.points[i].z());
    }
    return z;
  };
  EXPECT_LT(lowest(*below), 0.003f);
}

TEST(Symmetry, AlternativesDoNotChangeTheWinner) {
  const SyntheticView view = synthetic_view(standing(box_solid().mesh, 30 * kPlaneDegree), {});
  CompletionOptions options;
  const CompletedShape alone = complete_by_symmetry(view.view(), options);
  options.alternatives = 4;
  options.alternative_vote = 1;
  const CompletedShape winner = complete_by_symmetry(view.view(), options);
  EXPECT_FALSE(winner.alternatives.empty());
  EXPECT_EQ(alone.cloud_W.points, winner.cloud_W.points);
  EXPECT_EQ(alone.point_confidence, winner.point_confidence);
  options.alternatives = -1;
  EXPECT_THROW(complete_by_symmetry(view.view(), options), std::invalid_argument);
}

TEST(Symmetry, FillsTheFarSidesOfABoxSeenOverItsEdge) {
  const geometry::TriangleMesh truth = standing(box_solid().mesh, 40 * kPlaneDegree);
  const SyntheticView view = synthetic_view(truth, {.width = 320});
  std::vector<Eigen::Vector3d> corners_and_centers;
  for (const double x : {-0.03, 0.0, 0.03}) {
    for (const double y : {-0.045, 0.0, 0.045}) {
      if (x == 0 && y == 0) continue;
      for (const double z : {0.01, 0.06, 0.12}) {
        const Eigen::AngleAxisd turn(40 * kPlaneDegree, Eigen::Vector3d::UnitZ());
        corners_and_centers.push_back(turn * Eigen::Vector3d(x, y, z));
      }
    }
  }
  EXPECT_LT(greatest_gap(complete_by_symmetry(view.view()), corners_and_centers), 0.004);
  CompletionOptions one_plane;
  one_plane.second_plane = false;
  EXPECT_GT(greatest_gap(complete_by_symmetry(view.view(), one_plane), corners_and_centers), 0.02);
}

TEST(Symmetry, ClosesTheFarSideWhenTheBestPlaneRunsAlongTheSight) {
  // A jug: a long body whose neck stands over one end, looked at along its length.
  geometry::TriangleMesh jug = standing(geometry::make_box({0.12, 0.07, 0.1}), 0);
  const geometry::TriangleMesh neck = standing(geometry::make_box({0.03, 0.03, 0.13}), 0, 0.04, 0);
  const int first = static_cast<int>(jug.vertices.size());
  jug.vertices.insert(jug.vertices.end(), neck.vertices.begin(), neck.vertices.end());
  for (const Eigen::Vector3i& t : neck.triangles) {
    jug.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  const SyntheticView view = synthetic_view(jug, {});
  const std::vector<Eigen::Vector3d> back{{-0.06, 0, 0.03}, {-0.06, 0.02, 0.06}};
  const CompletedShape shape = complete_by_symmetry(view.view());
  EXPECT_EQ(shape.method, CompletionMethod::kMirror);
  EXPECT_GT(std::abs(shape.symmetry.normal_W.y()), 0.95);
  ASSERT_TRUE(shape.second_symmetry.has_value());
  EXPECT_LT(greatest_gap(shape, back), 0.015);
  CompletionOptions one_plane;
  one_plane.second_plane = false;
  EXPECT_GT(greatest_gap(complete_by_symmetry(view.view(), one_plane), back), 0.03);
}

TEST(Symmetry, PlaneStandsOnTheTableAndMirrorsTheViewpoint) {
  const SyntheticView view = synthetic_view(standing(box_solid().mesh, 0.5), {});
  const CompletedShape shape = complete_by_symmetry(view.view());
  EXPECT_NEAR(shape.symmetry.normal_W.norm(), 1, 1e-12);
  EXPECT_NEAR(shape.symmetry.normal_W.dot(view.table_W.normal), 0, 1e-12);
  const Eigen::Vector3d between = 0.5 * (shape.viewpoint_W + shape.mirrored_viewpoint_W);
  EXPECT_NEAR((between - shape.symmetry.point_W).dot(shape.symmetry.normal_W), 0, 1e-12);
  ASSERT_TRUE(shape.second_symmetry.has_value());
  EXPECT_NEAR(shape.second_symmetry->normal_W.dot(shape.symmetry.normal_W), 0, 1e-9);
}

TEST(Symmetry, KeepsTheSeenPointsFirstWithTheirColors) {
  SyntheticView view = synthetic_view(standing(box_solid().mesh, 0.5), {.width = 160});
  view.cloud_W.colors.assign(view.cloud_W.size(), geometry::Rgb{1, 2, 3});
  const CompletedShape shape = complete_by_symmetry(view.view());
  ASSERT_EQ(shape.origin.size(), shape.cloud_W.size());
  ASSERT_EQ(shape.cloud_W.colors.size(), shape.cloud_W.size());
  for (std::size_t i = 0; i < view.cloud_W.size(); ++i) {
    ASSERT_EQ(shape.cloud_W.points[i], view.cloud_W.points[i]);
    ASSERT_EQ(shape.origin[i], PointOrigin::kSeen);
  }
  EXPECT_NE(shape.origin.back(), PointOrigin::kSeen);
}

TEST(Symmetry, ListsTheHypothesesBestFirst) {
  const SyntheticView view = synthetic_view(standing(box_solid().mesh, 0.5), {.width = 320});
  const CompletionOptions options;
  const CompletedShape shape = complete_by_symmetry(view.view(), options);
  ASSERT_GE(shape.hypotheses.size(),
            static_cast<std::size_t>(options.orientations * options.shifts));
  EXPECT_EQ(shape.hypotheses.front().vote, shape.symmetry.vote);
  for (std::size_t i = 2; i < shape.hypotheses.size(); ++i) {
    ASSERT_LE(shape.hypotheses[i - 1].vote, shape.hypotheses[i].vote);
  }
  EXPECT_GT(shape.hypotheses.back().vote, 10 * shape.symmetry.vote);
}

TEST(Symmetry, VoteHasALowValueForTheTruthAndTellsItsParts) {
  const SyntheticView view = synthetic_view(standing(box_solid().mesh, 0.5), {});
  const CompletedShape shape = complete_by_symmetry(view.view());
  EXPECT_LT(shape.symmetry.outside, 1e-3);
  EXPECT_LT(shape.symmetry.in_front, 5e-3);
  EXPECT_LT(shape.symmetry.contradicted, 0.02);
  EXPECT_GT(shape.symmetry.coincident, 0.2);  // the top maps onto itself
}

TEST(Symmetry, VoteHardlyDependsOnTheCamerasResolution) {
  const geometry::TriangleMesh truth = standing(box_solid().mesh, 20 * kPlaneDegree);
  const auto worst = [&](int width, const CompletionOptions& options) {
    const SyntheticView view = synthetic_view(truth, {.width = width});
    return complete_by_symmetry(view.view(), options).hypotheses.back().vote;
  };
  CompletionOptions ours = as_published();
  ours.vote = VoteKind::kSupported;
  ours.support_weight = ours.oblique_weight = ours.depth_prior_weight = 0;
  EXPECT_NEAR(worst(320, ours) / worst(1280, ours), 1, 0.2);
  // The published one counts square pixels, 1/16, beside depths.
  EXPECT_LT(worst(320, as_published()) / worst(1280, as_published()), 0.2);
}

TEST(Symmetry, PublishedVoteAloneStaysWithinAGridStep) {
  for (const double yaw : {0.0, 10.0}) {
    const geometry::TriangleMesh truth = standing(long_box().mesh, yaw * kPlaneDegree, 0.1, 0.05);
    const SyntheticView view = synthetic_view(truth, {});
    const CompletedShape shape = complete_by_symmetry(view.view(), as_published());
    EXPECT_EQ(shape.cloud_W.size(), 2 * view.cloud_W.size());
    EXPECT_FALSE(shape.second_symmetry.has_value());
    const Eigen::Vector3d center = geometry::bounds(truth).center();
    // Its shallow valley (third power of the shift) allows for several millimetres.
    EXPECT_LT(std::abs(shape.symmetry.normal_W.dot(center - shape.symmetry.point_W)), 0.012);
  }
}

TEST(Symmetry, AsPublishedIsTheReference) {
  const SyntheticView view =
      synthetic_view(standing(box_solid().mesh, 0.3), {.depth_noise = 0.001, .width = 240});
  const CompletionOptions options = as_published();
  const CompletedShape shape = complete_by_symmetry(view.view(), options);
  const auto planes_C = reference_hypotheses(view.view(), 7, 5, options.max_angle);
  const SeenImages images = reference_images(view.view());
  ASSERT_EQ(shape.hypotheses.size(), planes_C.size() + 1);  // the winner stands first once more
  std::vector<std::pair<double, geometry::Plane>> votes;
  for (const auto& plane_C : planes_C) {
    const VoteTally tally = reference_tally(view.view(), images, plane_C, {});
    votes.emplace_back(tally.published_vote(), plane_C);
  }
  std::sort(votes.begin(), votes.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < votes.size(); ++i) {
    EXPECT_NEAR(shape.hypotheses[i + 1].vote, votes[i].first, 2e-3 * votes[i].first);
  }
  const Eigen::Vector3d normal_W = view.X_WC.linear() * votes.front().second.normal;
  EXPECT_GT(normal_W.dot(shape.symmetry.normal_W), 1 - 1e-9);
  EXPECT_NEAR(votes.front().second.signed_distance(view.X_WC.inverse() * shape.symmetry.point_W), 0,
              1e-9);
}

TEST(Symmetry, HandsBackDistinctPlanesBestFirst) {
  const SyntheticView view = synthetic_view(standing(square_box().mesh, 0.5), {.width = 320});
  CompletionOptions options;
  const CompletedShape shape = complete_by_symmetry(view.view(), options);
  ASSERT_GE(shape.planes.size(), 3u);
  ASSERT_LE(shape.planes.size(), static_cast<std::size_t>(options.planes));
  for (std::size_t i = 1; i < shape.planes.size(); ++i) {
    EXPECT_LE(shape.planes[i - 1].vote, shape.planes[i].vote);
  }
  // Of its four vertical planes of symmetry at least three are among the five.
  int found = 0;
  for (int k = 0; k < 4; ++k) {
    const double angle = 0.5 + k * std::numbers::pi / 4;
    const Eigen::Vector3d n(std::cos(angle), std::sin(angle), 0);
    found += std::any_of(shape.planes.begin(), shape.planes.end(), [&](const auto& plane) {
      return std::abs(n.dot(plane.normal_W)) > std::cos(3 * kPlaneDegree) &&
             std::abs(plane.normal_W.dot(plane.point_W)) < 0.004;
    });
  }
  EXPECT_GE(found, 3);
  options.planes = 1;
  EXPECT_EQ(complete_by_symmetry(view.view(), options).planes.size(), 1u);
}

TEST(Symmetry, TiltIsFreedWhenTheViewAsksForIt) {
  // A tall box_solid that leans by 6 degrees away from the camera.
  geometry::RigidTransform lean = geometry::RigidTransform::Identity();
  lean.linear() = Eigen::AngleAxisd(-6 * kPlaneDegree, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const geometry::TriangleMesh truth =
      standing(geometry::transformed(geometry::make_box({0.05, 0.07, 0.2}), lean), 0);
  const SyntheticView view = synthetic_view(truth, {.depth_noise = 0.0005});
  const Eigen::Vector3d normal = complete_by_symmetry(view.view()).symmetry.normal_W;
  EXPECT_NEAR(std::abs(normal.z()), std::sin(6 * kPlaneDegree), std::sin(2.5 * kPlaneDegree));
  CompletionOptions upright;
  upright.max_tilt = 0;
  EXPECT_NEAR(complete_by_symmetry(view.view(), upright).symmetry.normal_W.z(), 0, 1e-12);
}

TEST(Symmetry, SameInputGivesTheSameBits) {
  const SyntheticView view =
      synthetic_view(standing(box_solid().mesh, 0.3), {.depth_noise = 0.001, .width = 320});
  const CompletedShape first = complete_by_symmetry(view.view());
  const CompletedShape second = complete_by_symmetry(view.view());
  EXPECT_EQ(first.symmetry.vote, second.symmetry.vote);
  EXPECT_EQ(first.symmetry.point_W, second.symmetry.point_W);
  EXPECT_EQ(first.cloud_W.points, second.cloud_W.points);
}

TEST(Symmetry, OrderOfThePointsDoesNotMatter) {
  const SyntheticView view =
      synthetic_view(standing(box_solid().mesh, 0.3), {.depth_noise = 0.001, .width = 320});
  SyntheticView reversed = view;
  std::reverse(reversed.cloud_W.points.begin(), reversed.cloud_W.points.end());
  const CompletedShape first = complete_by_symmetry(view.view());
  const CompletedShape second = complete_by_symmetry(reversed.view());
  EXPECT_EQ(first.symmetry.vote, second.symmetry.vote);
  EXPECT_EQ(first.symmetry.point_W, second.symmetry.point_W);
  EXPECT_EQ(first.symmetry.normal_W, second.symmetry.normal_W);
  ASSERT_EQ(first.cloud_W.size(), second.cloud_W.size());
}

TEST(Symmetry, MovesWithARigidMotionOfEverything) {
  const SyntheticView view =
      synthetic_view(standing(box_solid().mesh, 0.3), {.depth_noise = 0.001});
  const CompletedShape shape = complete_by_symmetry(view.view());
  for (int i = 0; i < 5; ++i) {
    const geometry::RigidTransform X_VW = geometry::make_transform(
        Eigen::Quaterniond(Eigen::AngleAxisd(0.7 + i, Eigen::Vector3d(1, i - 2, 0.3).normalized())),
        {0.3 * i, -1, 0.5});
    const CompletedShape other = complete_by_symmetry(moved(view, X_VW).view());
    // Single precision moves a few points to another voxel.
    EXPECT_NEAR(other.symmetry.vote, shape.symmetry.vote, 0.01);
    const Eigen::Vector3d normal_V = X_VW.linear() * shape.symmetry.normal_W;
    EXPECT_GT(normal_V.dot(other.symmetry.normal_W), std::cos(1 * kPlaneDegree));
    const Eigen::Vector3d center_V = X_VW * Eigen::Vector3d(0, 0, 0.06);
    EXPECT_NEAR((center_V - X_VW * shape.symmetry.point_W).dot(normal_V),
                (center_V - other.symmetry.point_W).dot(other.symmetry.normal_W), 0.0005);
  }
}

TEST(Symmetry, SizeOfTheWorldDoesNotMatter) {
  // The same picture of a box_solid 1000 and 0.01 times the size, with the tolerance scaled alike.
  for (const double scale : {0.01, 1.0, 1000.0}) {
    const geometry::TriangleMesh truth =
        standing(geometry::make_box(scale * Eigen::Vector3d(0.06, 0.09, 0.12)), 20 * kPlaneDegree);
    const SyntheticView view = synthetic_view(truth, {.distance = 0.7 * scale});
    CompletionOptions options;
    options.depth_tolerance *= scale;
    const CompletedShape shape = complete_by_symmetry(view.view(), options);
    EXPECT_LT(mirrored_errors(shape, truth).back(), 0.002 * scale);
  }
}

// Nothing contradicts a mirror image beside the camera's picture, but what is in view as a whole
// does not go on there: a hammer, seen along its handle, came out as two, half a metre apart.
TEST(Symmetry, WhatIsInViewAsAWholeHasNoHalfBesideTheImage) {
  geometry::TriangleMesh hammer = geometry::make_box({0.3, 0.025, 0.025});
  for (Eigen::Vector3d& p : hammer.vertices) p.x() -= 0.15;
  const auto count = static_cast<int>(hammer.vertices.size());
  const geometry::TriangleMesh head = geometry::make_box({0.03, 0.12, 0.03});
  hammer.vertices.insert(hammer.vertices.end(), head.vertices.begin(), head.vertices.end());
  for (const Eigen::Vector3i& t : head.triangles) {
    hammer.triangles.emplace_back(t + Eigen::Vector3i::Constant(count));
  }
  for (const double yaw : {0.0, 0.1}) {
    const SyntheticView view = synthetic_view(standing(hammer, std::numbers::pi + yaw),
                                              {.elevation = 0.9, .distance = 0.5, .width = 320});
    const CompletedShape shape = complete_by_symmetry(view.view());
    EXPECT_LT(shape.evidence.unseen, 0.2);
    for (const Eigen::Vector3f& p_W : shape.cloud_W.points) EXPECT_LT(p_W.head<2>().norm(), 0.45f);
  }
}

}  // namespace
}  // namespace prehend::shape
