#include "prehend/surface/deviation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

TEST(Deviation, OfConcentricSpheresIsTheDifferenceOfTheirRadii) {
  const auto d =
      mesh_deviation(geometry::make_sphere(0.05, 128), geometry::make_sphere(0.052, 128));
  for (const auto& one : {d.to_second, d.from_second}) {
    EXPECT_NEAR(one.mean, 0.002, 2e-5);
    EXPECT_NEAR(one.percentile_95, 0.002, 3e-5);
    EXPECT_NEAR(one.max, 0.002, 1e-4);
  }
}

TEST(Deviation, IsDirected) {
  // A box against the same box with a thin rod on it: only the second's points are far.
  const auto box = geometry::make_box({0.1, 0.1, 0.1});
  const auto rod = shifted(geometry::make_box({0.002, 0.002, 0.05}), {0, 0, 0.075});
  const auto d = mesh_deviation(box, geometry::concatenated({box, rod}));
  EXPECT_LT(d.to_second.max, 1e-6);
  EXPECT_NEAR(d.from_second.max, 0.05, 1e-3);
}

TEST(Deviation, OfAWidenedBoxIsThatOfTheClosedForm) {
  // A unit box, and one that reaches out by d on both sides of x. A point of the small box's two x
  // faces, a third of its area, is min(d, its distance to the face's border) away, the others lie
  // on the large one. Of the large one's area the two x faces are d away; the strips of its other
  // faces are linearly between 0 and d away.
  const double d = 0.1;
  const auto deviation = mesh_deviation(geometry::make_box({1, 1, 1}),
                                        geometry::make_box({1 + 2 * d, 1, 1}), {.samples = 50000});
  const double inner = std::pow(1 - 2 * d, 3);
  const double to_mean = (1 - inner) / 6 / 3;
  const double to_mean_square = (d * d - 8 * d * d * d / 3 + 2 * d * d * d * d) / 3;
  EXPECT_NEAR(deviation.to_second.mean, to_mean, 1e-4);
  EXPECT_NEAR(deviation.to_second.variance, to_mean_square - to_mean * to_mean, 1e-5);
  EXPECT_NEAR(deviation.to_second.percentile_95, d, 1e-6);
  EXPECT_NEAR(deviation.to_second.max, d, 1e-6);
  const double strips = 4 * 2 * d;
  const double area = 6 + strips;
  const double mean = (2 * d + strips * d / 2) / area;
  const double mean_square = (2 * d * d + strips * d * d / 3) / area;
  EXPECT_NEAR(deviation.from_second.mean, mean, 1e-4);
  EXPECT_NEAR(deviation.from_second.variance, mean_square - mean * mean, 1e-5);
  EXPECT_NEAR(deviation.from_second.max, d, 1e-6);
}

TEST(Deviation, ToItselfIsZero) {
  const auto mesh = make_l_shape(0.05);
  EXPECT_LT(mesh_deviation(mesh, mesh).to_second.max, 1e-7);
}

// Two thirds of a cube's area turn with it about the vertical.
TEST(NormalError, OfATurnedCubeIsTheTurn) {
  const auto cube = geometry::make_box({0.1, 0.1, 0.1});
  geometry::RigidTransform turn = geometry::RigidTransform::Identity();
  turn.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_NEAR(median_normal_error(geometry::transformed(cube, turn), cube), 0.1, 1e-9);
  EXPECT_NEAR(median_normal_error(cube, cube), 0, 1e-7);
  EXPECT_THROW(median_normal_error({}, cube), geometry::InputError);
  EXPECT_THROW(median_normal_error(cube, {}), geometry::InputError);
}

TEST(SampleSurface, IsUniformOverTheArea) {
  // A small and a large square: points in proportion to 1 : 9.
  geometry::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0},  {1, 0, 0},  {1, 1, 0},  {0, 1, 0},
                   {10, 0, 0}, {13, 0, 0}, {13, 3, 0}, {10, 3, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  int small = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : sample_surface(mesh, 10000, 5)) {
    if (p.x() < 5)
      ++small;
    else
      mean += p / 9000;
  }
  EXPECT_NEAR(small, 1000, 2);
  EXPECT_NEAR(mean.x(), 11.5, 0.03);
  EXPECT_NEAR(mean.y(), 1.5, 0.03);
}

TEST(SampleSurface, SeedDecides) {
  const auto mesh = geometry::make_sphere(0.05);
  EXPECT_EQ(sample_surface(mesh, 100, 1), sample_surface(mesh, 100, 1));
  EXPECT_NE(sample_surface(mesh, 100, 1), sample_surface(mesh, 100, 2));
}

TEST(Deviation, HostileInputIsRefused) {
  EXPECT_THROW(sample_surface({}, 10, 1), geometry::InputError);
  EXPECT_THROW(deviation({}, geometry::MeshQuery(geometry::make_sphere(1))), geometry::InputError);
  EXPECT_THROW(
      deviation({Eigen::Vector3d::Constant(NAN)}, geometry::MeshQuery(geometry::make_sphere(1))),
      geometry::InputError);
  EXPECT_THROW(sample_surface(geometry::make_sphere(1), 0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::surface
