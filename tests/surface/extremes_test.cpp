// Inputs at the edge of what there can be: each gives a right answer or one clear error.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/surface/model.h"
#include "tests/surface/manifold.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::PointCloud;
using geometry::TriangleMesh;

TriangleMesh box_of(double size) { return geometry::make_box(size * Eigen::Vector3d(0.6, 0.8, 1)); }

/// A completed shape of seen points only, looked at from outside along each point's normal.
PointCloud cloud_of(const TriangleMesh& mesh, int points) { return sampled(mesh, points); }

PointCloud moved(PointCloud cloud, const geometry::RigidTransform& X) {
  for (auto& p : cloud.points) p = (X * p.cast<double>()).cast<float>();
  for (auto& n : cloud.normals) n = (X.linear() * n.cast<double>()).cast<float>();
  return cloud;
}

double relative_error(const TriangleMesh& mesh, const TriangleMesh& truth) {
  const MeshDeviation d = mesh_deviation(mesh, truth, {.samples = 4000});
  return std::max(d.to_second.mean, d.from_second.mean) / geometry::bounds(truth).diagonal().norm();
}

/// One line that names what is wrong and how to mend it.
template <typename Function>
void expect_clear_error(Function f, const std::string& word) {
  try {
    f();
    FAIL() << "no error about " << word;
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(word), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
}

TEST(Extremes, FromAMillimetreToTenMetres) {
  for (const double size : {0.001, 0.01, 1.0, 10.0}) {
    const auto mesh = reconstruct(cloud_of(box_of(size), 10000), std::nullopt);
    EXPECT_LT(relative_error(mesh, box_of(size)), 5e-4) << size;
    EXPECT_NEAR(geometry::mass_properties(mesh).volume / (0.48 * size * size * size), 1, 0.01);
  }
}

TEST(Extremes, TenKilometresFromTheOrigin) {
  // Single precision has steps of a millimetre there; the cloud is no better than that.
  const Eigen::Vector3d far(6000, -8000, 100);
  const TriangleMesh truth = shifted(box_of(0.2), far);
  const PointCloud cloud = cloud_of(truth, 20000);
  const auto mesh = reconstruct(cloud, std::nullopt);
  ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
  EXPECT_LT(relative_error(shifted(mesh, -far), box_of(0.2)) * 0.28, 0.0006);
}

TEST(Extremes, ThreePointsToAMillion) {
  for (const int points : {0, 1, 3, 10, 29}) {
    expect_clear_error(
        [&] {
          PointCloud cloud = cloud_of(box_of(0.1), 30);
          cloud.points.resize(points);
          cloud.normals.resize(points);
          reconstruct(cloud, std::nullopt);
        },
        "too few");
  }
  // Thirty points say little, but enclose something.
  for (const int points : {30, 100, 1000}) {
    const auto mesh = reconstruct(cloud_of(geometry::make_sphere(0.05), points), std::nullopt);
    ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
    const double volume = 4.0 / 3 * EIGEN_PI * 0.05 * 0.05 * 0.05;
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume,
                (points < 100 ? 0.35 : 0.1) * volume)
        << points;
  }
  const auto mesh = reconstruct(cloud_of(box_of(0.1), 1000000), std::nullopt);
  EXPECT_LT(relative_error(mesh, box_of(0.1)), 3e-4);
}

TEST(Extremes, PointsWithoutASolid) {
  PointCloud cloud = cloud_of(box_of(0.1), 500);
  PointCloud coincident = cloud;
  for (auto& p : coincident.points) p = cloud.points[0];
  expect_clear_error([&] { reconstruct(coincident, std::nullopt); }, "coincide");
  PointCloud collinear = cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    collinear.points[i] = {1e-4f * static_cast<float>(i), 0, 0};
    collinear.normals[i] = {0, 0, 1};
  }
  expect_clear_error([&] { reconstruct(collinear, std::nullopt); }, "no watertight mesh");
  PointCloud coplanar = cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    coplanar.points[i].z() = 0;
    coplanar.normals[i] = {0, 0, 1};
  }
  expect_clear_error([&] { reconstruct(coplanar, std::nullopt); }, "no watertight mesh");
}

TEST(Extremes, DuplicatedPointsChangeNothingMuch) {
  const PointCloud cloud = cloud_of(box_of(0.1), 10000);
  PointCloud doubled = cloud;
  for (int copy = 0; copy < 3; ++copy) {
    doubled.points.insert(doubled.points.end(), cloud.points.begin(), cloud.points.end());
    doubled.normals.insert(doubled.normals.end(), cloud.normals.begin(), cloud.normals.end());
  }
  const auto once = reconstruct(cloud, std::nullopt);
  EXPECT_LT(relative_error(reconstruct(doubled, std::nullopt), once), 2e-4);
  // A thousand copies of one point are still one place.
  PointCloud heavy = cloud;
  heavy.points.insert(heavy.points.end(), 1000, cloud.points[0]);
  heavy.normals.insert(heavy.normals.end(), 1000, cloud.normals[0]);
  EXPECT_LT(relative_error(reconstruct(heavy, std::nullopt), once), 5e-4);
}

TEST(Extremes, NumbersThatAreNoneAreRefused) {
  const PointCloud cloud = cloud_of(box_of(0.1), 500);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    PointCloud point = cloud;
    point.points[17].y() = bad;
    expect_clear_error([&] { reconstruct(point, std::nullopt); }, "not finite");
    PointCloud normal = cloud;
    normal.normals[17].y() = bad;
    expect_clear_error([&] { reconstruct(normal, std::nullopt); }, "not finite");
  }
  PointCloud huge = cloud;
  huge.points[0] = Eigen::Vector3f::Constant(3e38f);
  EXPECT_NO_THROW({
    try {
      reconstruct(huge, std::nullopt);
    } catch (const InputError&) {
    }
  });
}

TEST(Extremes, NoiseIsFollowedNoFartherThanItReaches) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0, 1);
  for (const double noise : {0.0, 0.0005, 0.002, 0.005, 0.02}) {
    PointCloud cloud = cloud_of(box_of(0.2), 20000);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.points[i] += static_cast<float>(noise) * normal(random) * cloud.normals[i];
    }
    const auto mesh = reconstruct(cloud, std::nullopt);
    ASSERT_TRUE(geometry::find_defects(mesh).watertight());
    const MeshDeviation d = mesh_deviation(mesh, box_of(0.2), {.samples = 4000});
    EXPECT_LT(d.from_second.mean, 0.8 * noise + 1e-4) << noise;
  }
}

TEST(Extremes, MostOutliersGoBeforeTheSurfaceIsMade) {
  // As many outliers as points, spread over a cube three times the size of the box.
  for (const int outliers : {100, 2000, 10000}) {
    shape::CompletedShape shape;
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(-0.15f, 0.15f);
    const PointCloud box = cloud_of(shifted(box_of(0.1), {0, 0, 0.05}), 10000);
    shape.cloud_W.points = box.points;
    for (int i = 0; i < outliers; ++i) {
      shape.cloud_W.points.emplace_back(uniform(random), uniform(random), uniform(random));
    }
    shape.origin.assign(shape.cloud_W.size(), shape::PointOrigin::kSeen);
    OrientedCloudOptions options;
    options.spacing = 0.0015;
    options.outliers.deviations = 0.5;
    const PointCloud kept = oriented_cloud(shape, options);
    int far = 0;
    const TriangleMesh truth = shifted(box_of(0.1), {0, 0, 0.05});
    const geometry::MeshQuery query(truth);
    for (const auto& p : kept.points) far += query.nearest(p.cast<double>())->distance > 0.01;
    // Of as many outliers as points, one in seven of what is left is still one: those near the box.
    EXPECT_LT(far, (outliers > 5000 ? 0.2 : 0.08) * static_cast<double>(kept.size())) << outliers;
    EXPECT_LT(far, 0.2 * outliers);
    EXPECT_GT(kept.size() - far, 3000u) << outliers;
  }
}

TEST(Extremes, InvertedNormalsEncloseNothing) {
  PointCloud cloud = cloud_of(box_of(0.1), 5000);
  for (auto& n : cloud.normals) n = -n;
  expect_clear_error([&] { reconstruct(cloud, std::nullopt); }, "normals");
  // A tenth of them does not matter.
  for (auto& n : cloud.normals) n = -n;
  for (std::size_t i = 0; i < cloud.size(); i += 10) cloud.normals[i] = -cloud.normals[i];
  EXPECT_LT(relative_error(reconstruct(cloud, std::nullopt), box_of(0.1)), 3e-3);
}

TEST(Extremes, OrderAndThreadsDoNotMatterToTheLastBit) {
  const PointCloud cloud = cloud_of(box_of(0.1), 5000);
  const auto first = reconstruct(cloud, geometry::Plane{Eigen::Vector3d::UnitZ(), -0.05});
  std::vector<int> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::mt19937 random(3);
  std::shuffle(order.begin(), order.end(), random);
  const PointCloud shuffled = geometry::select(cloud, order);
  std::vector<TriangleMesh> others(4);
  std::vector<std::thread> threads;
  for (auto& other : others) {
    threads.emplace_back([&other, &shuffled] {
      other = reconstruct(shuffled, geometry::Plane{Eigen::Vector3d::UnitZ(), -0.05});
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& other : others) {
    EXPECT_EQ(first.vertices, other.vertices);
    EXPECT_EQ(first.triangles, other.triangles);
  }
}

TEST(Extremes, ARigidMotionMovesTheMesh) {
  // The frame of the grid moves with the points; what is left is the rounding of the moved cloud.
  const PointCloud cloud = cloud_of(box_of(0.1), 10000);
  const auto here = reconstruct(cloud, std::nullopt);
  for (const double angle : {0.3, 1.7, 3.0}) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.linear() =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    X.translation() << 0.02, -0.05, 0.03;
    const auto there = reconstruct(moved(cloud, X), std::nullopt);
    const auto back = geometry::transformed(there, X.inverse(Eigen::Isometry));
    EXPECT_NEAR(geometry::mass_properties(back).volume / geometry::mass_properties(here).volume, 1,
                1e-6);
    const MeshDeviation d = mesh_deviation(here, back, {.samples = 4000});
    EXPECT_LT(d.to_second.mean, 1e-6 * 0.1);
  }
}

}  // namespace
}  // namespace prehend::surface
