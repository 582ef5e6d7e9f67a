#include "prehend/shape/fallbacks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/shape/symmetry.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

struct Prepared {
  SyntheticView seen;
  VotingPoints voting;
  SeenMap map;
  geometry::RigidTransform X_CT;

  explicit Prepared(const geometry::TriangleMesh& mesh, const ViewOptions& options = {})
      : seen(synthetic_view(mesh, options)),
        voting(make_voting_points(seen.view(), 0.02)),
        map(make_seen_map(seen.view(), window_round_object(seen.view(), 0.5))),
        X_CT(seen.X_WC.inverse() * voting.X_WT) {}

  FallbackInput input() const {
    return {voting, map, seen.camera, X_CT, 0.003, 0.015 * voting.extent};
  }
  std::vector<double> errors(const Fallback& fallback, const geometry::TriangleMesh& truth) const {
    const geometry::MeshQuery query(truth);
    std::vector<double> result;
    for (const Eigen::Vector3d& p_T : fallback.points_T) {
      result.push_back(query.nearest(voting.X_WT * p_T)->distance);
    }
    std::sort(result.begin(), result.end());
    return result;
  }
};

TEST(Fallbacks, RevolutionFindsAxisAndRadii) {
  const geometry::TriangleMesh truth = standing(
      geometry::make_revolution({{0.035, 0}, {0.04, 0.05}, {0.025, 0.12}}, 128), 0, 0.1, 0.05);
  const Prepared p(truth, {.elevation = 0.4, .depth_noise = 0.0005});
  const auto fallback = revolved(p.input());
  ASSERT_TRUE(fallback.has_value());
  const Eigen::Vector3d axis_W =
      p.voting.X_WT * Eigen::Vector3d(fallback->center_T.x(), fallback->center_T.y(), 0);
  EXPECT_NEAR(axis_W.x(), 0.1, 0.002);
  EXPECT_NEAR(axis_W.y(), 0.05, 0.002);
  EXPECT_LT(fallback->contradicted, 0.1);
  const auto errors = p.errors(*fallback, truth);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.004);
}

TEST(Fallbacks, RevolutionIgnoresAHandle) {
  geometry::TriangleMesh mug = geometry::make_revolution({{0.04, 0}, {0.04, 0.09}}, 96);
  geometry::RigidTransform beside = geometry::RigidTransform::Identity();
  beside.translation() = Eigen::Vector3d(0, 0.055, 0.045);
  const geometry::TriangleMesh handle =
      geometry::transformed(geometry::make_box({0.01, 0.03, 0.05}), beside);
  const int first = static_cast<int>(mug.vertices.size());
  mug.vertices.insert(mug.vertices.end(), handle.vertices.begin(), handle.vertices.end());
  for (const Eigen::Vector3i& t : handle.triangles) {
    mug.triangles.push_back(t + Eigen::Vector3i::Constant(first));
  }
  const Prepared p(standing(mug, 0), {.elevation = 0.4});
  const auto fallback = revolved(p.input());
  ASSERT_TRUE(fallback.has_value());
  const Eigen::Vector3d axis_W =
      p.voting.X_WT * Eigen::Vector3d(fallback->center_T.x(), fallback->center_T.y(), 0);
  EXPECT_LT(axis_W.head<2>().norm(), 0.005);
}

TEST(Fallbacks, ExtrusionReachesTheTableUnderTheOutline) {
  const geometry::TriangleMesh truth = standing(geometry::make_box({0.08, 0.12, 0.05}), 0.3);
  const Prepared p(truth, {.elevation = 0.9});
  const auto fallback = extruded(p.input());
  ASSERT_TRUE(fallback.has_value());
  const auto errors = p.errors(*fallback, truth);
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.004);
  double least = 1;
  for (const auto& q : fallback->points_T) least = std::min(least, q.z());
  EXPECT_LT(least, 0.002);
  EXPECT_LT(fallback->center_T.norm(), 2);
}

TEST(Fallbacks, ExtrusionOfOneUprightFaceTellsNothing) {
  // From table height only the front is seen: its footprint is a line.
  const Prepared p(standing(geometry::make_box({0.06, 0.12, 0.1}), 0.02),
                   {.elevation = 0.01, .depth_noise = 0.0005});
  EXPECT_FALSE(extruded(p.input()).has_value());
}

// The top of a box is seen at a slant: its points are further apart than the cells are wide.
TEST(Fallbacks, ExtrusionHasNoWallsWithin) {
  const geometry::TriangleMesh truth = standing(geometry::make_box({0.08, 0.06, 0.1}), 0);
  const Prepared p(truth, {.width = 320});
  const auto fallback = extruded(p.input());
  ASSERT_TRUE(fallback.has_value());
  const geometry::MeshQuery sides(truth);
  ASSERT_EQ(fallback->normals_T.size(), fallback->points_T.size());
  for (std::size_t i = 0; i < fallback->points_T.size(); ++i) {
    const Eigen::Vector3d p_W = p.voting.X_WT * fallback->points_T[i];
    EXPECT_LT(sides.nearest(p_W)->distance, 0.005) << p_W.transpose();
    EXPECT_NEAR(fallback->normals_T[i].norm(), 1, 1e-9);
  }
}

TEST(Fallbacks, HullEnclosesWhatWasSeen) {
  const geometry::TriangleMesh truth = standing(geometry::make_box({0.06, 0.09, 0.12}), 0.7);
  const Prepared p(truth);
  const Fallback fallback = hulled(p.input()).value();
  Eigen::AlignedBox3d seen, hull;
  for (const auto& q : p.voting.points_T) seen.extend(q);
  for (const auto& q : fallback.points_T) hull.extend(q);
  EXPECT_LT((seen.max() - hull.max()).cwiseAbs().maxCoeff(), 0.006);
  EXPECT_NEAR(hull.min().z(), 0, 0.001) << "its sides go down to the table";
  // No foot: the sides' points face outwards, and none faces the table.
  ASSERT_EQ(fallback.normals_T.size(), fallback.points_T.size());
  const Eigen::Vector3d middle = hull.center();
  for (std::size_t i = 0; i < fallback.points_T.size(); ++i) {
    EXPECT_GT(fallback.normals_T[i].dot(fallback.points_T[i] - middle), 0);
    EXPECT_GT(fallback.normals_T[i].z(), -0.9);
  }
}

/// Spheres of 3 cm at random places of a slab: no plane mirrors them.
geometry::TriangleMesh asymmetric() {
  geometry::TriangleMesh mesh;
  const Eigen::Vector3d sizes[] = {{0.2, 0.03, 0.04}, {0.03, 0.12, 0.09}, {0.05, 0.02, 0.16}};
  const Eigen::Vector3d places[] = {{0, 0, 0}, {0.08, 0.07, 0.025}, {-0.05, -0.02, 0.06}};
  for (int i = 0; i < 3; ++i) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.translation() = places[i];
    const auto part = geometry::transformed(geometry::make_box(sizes[i]), X);
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const Eigen::Vector3i& t : part.triangles) {
      mesh.triangles.push_back(t + Eigen::Vector3i::Constant(first));
    }
  }
  return mesh;
}

TEST(Fallbacks, TwoHeadsAreRefusedAndTheResultSaysSo) {
  const SyntheticView view = synthetic_view(standing(asymmetric(), 0.5), {.width = 320});
  CompletionOptions strict;
  strict.max_contradicted = 0.02;
  const CompletedShape shape = complete_by_symmetry(view.view(), strict);
  EXPECT_NE(shape.method, CompletionMethod::kMirror);
  EXPECT_THAT(shape.refused, testing::HasSubstr("mirror"));
  EXPECT_LT(shape.confidence, 0.7);
  ASSERT_GT(shape.cloud_W.size(), view.cloud_W.size() + 100);
  ASSERT_EQ(shape.origin.size(), shape.cloud_W.size());
  // What it predicts lies where the camera did not look through.
  const SeenMap map = make_seen_map(view.view(), window_round_object(view.view(), 0.5));
  for (std::size_t i = view.cloud_W.size(); i < shape.cloud_W.size(); i += 17) {
    const Eigen::Vector3d p_C = view.X_WC.inverse() * shape.cloud_W.points[i].cast<double>();
    EXPECT_LE(evidence_about(map, view.camera, p_C, strict.depth_tolerance).contradicted, 0.51);
  }
  // Never refused when told so.
  CompletionOptions lenient;
  lenient.max_contradicted = 1;
  lenient.min_support = 0;
  EXPECT_EQ(complete_by_symmetry(view.view(), lenient).method, CompletionMethod::kMirror);
}

// A plane refused for 16 % of its points gave way to an extrusion of which half stood where the
// camera had looked through; what was left of its walls looked like a comb.
TEST(Fallbacks, NoneIsWorseThanThePlaneThatWasRefused) {
  std::map<CompletionMethod, int> methods;
  CompletionOptions strict;
  strict.max_contradicted = 0.02;
  for (const CompletionOptions& options : {CompletionOptions{}, strict}) {
    for (int k = 0; k < 24; ++k) {
      const SyntheticView view = synthetic_view(
          standing(asymmetric(), 0.26 * k),
          {.elevation = 0.25 + 0.3 * (k % 4), .depth_noise = 0.001 * (k % 2), .width = 320});
      const CompletedShape shape = complete_by_symmetry(view.view(), options);
      ++methods[shape.method];
      if (shape.method == CompletionMethod::kMirror) {
        EXPECT_EQ(shape.refused, "");
        continue;
      }
      double percent = -1;
      ASSERT_EQ(std::sscanf(shape.refused.c_str(), "mirror: the view speaks against %lf", &percent),
                1)
          << shape.refused;
      EXPECT_LE(100 * shape.evidence.contradicted, percent + 0.5)
          << name(shape.method) << " at view " << k << "; " << shape.refused;
      EXPECT_EQ(shape.evidence.method, shape.method);
      EXPECT_LT(shape.confidence, 0.95);
    }
  }
  // Both ways out are taken.
  EXPECT_GT(methods[CompletionMethod::kRotation] + methods[CompletionMethod::kExtrusion] +
                methods[CompletionMethod::kConvexHull],
            0);
  EXPECT_GT(methods[CompletionMethod::kRefusedMirror], 0);
}

}  // namespace
}  // namespace prehend::shape
