#include "prehend/surface/mesh_parts.h"

#include <gtest/gtest.h>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::surface {
namespace {

geometry::TriangleMesh box_at(const Eigen::Vector3d& size, double x) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation().x() = x;
  return geometry::transformed(geometry::make_box(size), X);
}

TEST(MeshParts, ACrumbGoes) {
  const auto body = box_at({0.1, 0.1, 0.1}, 0);
  const auto parts =
      solid_parts(geometry::concatenated({body, box_at({0.01, 0.01, 0.01}, 0.2)}), 0.05);
  EXPECT_NEAR(geometry::mass_properties(parts).volume, 1e-3, 1e-12);
}

TEST(MeshParts, APartOfSomeVolumeStays) {
  const auto body = box_at({0.1, 0.1, 0.1}, 0);
  const auto parts =
      solid_parts(geometry::concatenated({body, box_at({0.04, 0.04, 0.04}, 0.2)}), 0.05);
  EXPECT_NEAR(geometry::mass_properties(parts).volume, 1e-3 + 6.4e-5, 1e-12);
}

// The head of a spray bottle, whose neck nobody sees, was dropped.
TEST(MeshParts, AShellOfSomeAreaStays) {
  const auto body = box_at({0.1, 0.1, 0.1}, 0);
  const auto parts =
      solid_parts(geometry::concatenated({body, box_at({0.002, 0.08, 0.08}, 0.2)}), 0.05);
  EXPECT_NEAR(geometry::mass_properties(parts).volume, 1e-3 + 1.28e-5, 1e-12);
}

TEST(MeshParts, WhatIsInsideOutGoes) {
  geometry::TriangleMesh hollow = box_at({0.09, 0.09, 0.09}, 0);
  for (Eigen::Vector3i& t : hollow.triangles) std::swap(t.y(), t.z());
  const auto parts =
      solid_parts(geometry::concatenated({box_at({0.1, 0.1, 0.1}, 0), hollow}), 0.05);
  EXPECT_NEAR(geometry::mass_properties(parts).volume, 1e-3, 1e-12);
  EXPECT_TRUE(solid_parts(hollow, 0.05).empty());
  EXPECT_TRUE(solid_parts({}, 0.05).empty());
}

}  // namespace
}  // namespace prehend::surface
