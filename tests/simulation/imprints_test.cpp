#include "eval/touch/imprints.h"

#include <gtest/gtest.h>

#include "eval/touch/pressing.h"

namespace prehend::eval::touch {
namespace {

TEST(Imprints, PerforatedBlocksAreClosedSolids) {
  const Eigen::Vector3d size(0.04, 0.03, 0.036);
  for (std::size_t i = 0; i < holes().size(); ++i) {
    const Hole& other = holes()[(i + 3) % holes().size()];
    const geometry::TriangleMesh mesh =
        perforated_block(size, {&holes()[i], {0.002, 0.001}}, {&other, {-0.003, 0}});
    EXPECT_TRUE(geometry::find_defects(mesh).watertight())
        << holes()[i].name << ": " << geometry::find_defects(mesh).to_string();
    double area = 0;  // of both holes
    for (double x = -0.02; x < 0.02; x += 1e-4) {
      for (double y = -0.02; y < 0.02; y += 1e-4) {
        area += 1e-8 * (holes()[i].contains({x, y}) + other.contains({x, y}));
      }
    }
    const double volume = size.prod() - 0.008 * area;
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume, 0.01 * volume) << holes()[i].name;
  }
}

TEST(Imprints, ThePadsFeelTheHoles) {
  Presser presser({});
  const geometry::TriangleMesh mesh =
      perforated_block({0.08, 0.04, 0.08}, {&holes()[1], {0.001, 0.001}}, {nullptr, {0, 0}});
  const auto pressed =
      presser.press(contact::Shape::mesh(mesh), geometry::RigidTransform::Identity());
  ASSERT_TRUE(pressed);
  // Squares of 16.8 mm: texels whose middle is in it; nothing on the other side.
  int empty = 0, whole = 0;
  for (std::size_t i = 0; i < 84; ++i) {
    const Eigen::Vector3d p = presser.pad().layout.position(i);
    const bool in_hole = holes()[1].contains({p.x() - 0.001, p.y() - 0.001});
    EXPECT_EQ(pressed->frames[0][i] == 0, in_hole) << i;
    empty += pressed->frames[0][i] == 0;
    whole += pressed->frames[1][i] > 0;
  }
  EXPECT_EQ(empty, 25);
  EXPECT_EQ(whole, 84);
  EXPECT_NEAR(pressed->opening, 0.04, 0.001);
  // What is wider than the jaws open is not pressed.
  EXPECT_FALSE(
      presser.press(contact::Shape::box({0.02, 0.08, 0.02}), geometry::RigidTransform::Identity()));
}

}  // namespace
}  // namespace prehend::eval::touch
