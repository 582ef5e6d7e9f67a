#include "prehend/surface/empty_space.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/model.h"
#include "tests/shape/synthetic_view.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

constexpr double kRadius = 0.05;

/// A camera 0.5 m over the origin that saw `depth` in each pixel.
shape::SeenSpace seen_from_above(float depth) {
  const geometry::PinholeCamera camera{200, 200, 500, 500, 99.5, 99.5};
  geometry::RigidTransform X_WC = geometry::RigidTransform::Identity();
  X_WC.linear().diagonal() = Eigen::Vector3d(1, -1, -1);
  X_WC.translation() = Eigen::Vector3d(0, 0, 0.5);
  return {camera, X_WC, {200, 200, depth}};
}

/// Looked through down to 0.6 m right of the image's middle; nothing known left of it.
shape::SeenSpace half_seen() {
  shape::SeenSpace space = seen_from_above(0.6f);
  for (int v = 0; v < 200; ++v) {
    for (int u = 0; u < 100; ++u) {
      space.empty_until.at(u, v) = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return space;
}

// The half of a ball that was seen to be empty is cut away, exactly as far as that was seen.
TEST(EmptySpace, IsLeftOut) {
  const geometry::PointCloud cloud = sampled(geometry::make_sphere(kRadius, 64), 20000);
  const shape::SeenSpace space = half_seen();
  for (const int resolution : {64, 128}) {
    const auto mesh =
        fast_poisson(cloud, std::nullopt, {.resolution = resolution}, {.seen = {&space}}).mesh;
    EXPECT_TRUE(geometry::find_defects(mesh).watertight());
    const double whole = 4. / 3 * std::numbers::pi * std::pow(kRadius, 3);
    const double spacing = 1.25 * 2 * kRadius / resolution;
    // Half, and the thickness of half a cell at the cut.
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, 0.5 * whole,
                spacing * std::numbers::pi * kRadius * kRadius);
    const geometry::RigidTransform X_CW = space.X_WC.inverse();
    for (const Eigen::Vector3d& p : mesh.vertices) {
      const Eigen::Vector3d p_C = X_CW * p;
      // A cell's width within the border of what was seen.
      if (space.camera.project(p_C).x() < 99.5 + 500 * spacing / p_C.z()) continue;
      EXPECT_LT(shape::depth_in_empty_space(space, p_C), 0.005 + 2 * spacing) << p.transpose();
    }
  }
}

TEST(EmptySpace, WithoutAnyTheSurfaceIsTheSameToTheLastBit) {
  const geometry::PointCloud cloud = sampled(geometry::make_sphere(kRadius, 64), 5000);
  const auto plain = fast_poisson(cloud, std::nullopt).mesh;
  for (const float depth : {std::numeric_limits<float>::quiet_NaN(), 0.44f}) {
    const shape::SeenSpace space = seen_from_above(depth);
    EXPECT_EQ(fast_poisson(cloud, std::nullopt, {}, {.seen = {&space}}).mesh.vertices,
              plain.vertices);
  }
}

// A hand went through the right half of a ball that was predicted.
TEST(EmptySpace, WhatWasSweptIsLeftOut) {
  const geometry::PointCloud cloud = sampled(geometry::make_sphere(kRadius, 64), 20000);
  geometry::SweptSpace swept({Eigen::Vector3d::Constant(-0.08), Eigen::Vector3d::Constant(0.08)},
                             0.002);
  for (double y = -0.06; y <= 0.06; y += 0.004) {
    for (double z = -0.06; z <= 0.06; z += 0.004) swept.add_path({0.012, y, z}, {0.07, y, z}, 0.01);
  }
  for (const int resolution : {64, 128}) {
    const auto mesh =
        fast_poisson(cloud, std::nullopt, {.resolution = resolution}, {.swept = &swept}).mesh;
    EXPECT_TRUE(geometry::find_defects(mesh).watertight());
    const double whole = 4. / 3 * std::numbers::pi * std::pow(kRadius, 3);
    const double spacing = 1.25 * 2 * kRadius / resolution;
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, 0.5 * whole,
                4 * spacing * std::numbers::pi * kRadius * kRadius);
    for (const Eigen::Vector3d& p : mesh.vertices) EXPECT_LT(swept.depth(p), 3 * spacing);
  }
  // What was swept elsewhere changes nothing.
  geometry::SweptSpace elsewhere(
      {Eigen::Vector3d::Constant(-0.08), Eigen::Vector3d::Constant(0.08)}, 0.002);
  elsewhere.add_ball({0.07, 0.07, 0.07}, 0.01);
  EXPECT_EQ(fast_poisson(cloud, std::nullopt, {}, {.swept = &elsewhere}).mesh.vertices,
            fast_poisson(cloud, std::nullopt).mesh.vertices);
}

// The camera sees the table through a ring: so may a hand.
TEST(EmptySpace, TheHoleOfARingStaysOpen) {
  const auto truth = shape::standing(make_ring(0.07, 0.05, 0.02), 0);
  const shape::SyntheticView view = shape::synthetic_view(truth, {.elevation = 0.9});
  const shape::CompletedShape completed = shape::complete_by_symmetry(view.view());
  const ObjectModel open = make_object_model(completed, view.table_W);
  ModelOptions options;
  options.keep_out_of_empty_space = false;
  const ObjectModel filled = make_object_model(completed, view.table_W, options);
  const double volume = geometry::mass_properties(truth).volume;
  const geometry::MeshQuery in_open(open.mesh_W), in_filled(filled.mesh_W);
  EXPECT_FALSE(in_open.contains({0, 0, 0.002}));
  EXPECT_TRUE(in_filled.contains({0, 0, 0.002}));
  EXPECT_NEAR(open.mass_properties.volume / volume, 1, 0.25);
  EXPECT_GT(filled.mass_properties.volume / volume, open.mass_properties.volume / volume);
  EXPECT_TRUE(open.defects.watertight());
}

}  // namespace
}  // namespace prehend::surface
