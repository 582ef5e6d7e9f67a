#include "prehend/geometry/kept_by_mesh.h"

#include <gtest/gtest.h>

namespace prehend::geometry {
namespace {

TEST(KeptByMesh, MakesOncePerMeshAndParameterWhileTheMeshIsInUse) {
  KeptByMesh<double> kept;
  int made = 0;
  const auto volume = [&made](const TriangleMesh& mesh, double parameter) {
    ++made;
    return parameter * mass_properties(mesh).volume;
  };
  auto box = std::make_shared<const TriangleMesh>(make_box({1, 1, 1}));
  const auto other = std::make_shared<const TriangleMesh>(make_box({2, 1, 1}));
  EXPECT_NEAR(kept.of(box, 1, volume), 1, 1e-12);
  EXPECT_NEAR(kept.of(box, 1, volume), 1, 1e-12);
  EXPECT_EQ(made, 1);
  EXPECT_NEAR(kept.of(box, 3, volume), 3, 1e-12);
  EXPECT_NEAR(kept.of(other, 1, volume), 2, 1e-12);
  EXPECT_EQ(made, 3);
  // Another mesh, that may have come to lie where the first was.
  for (int i = 2; i < 10; ++i) {
    box.reset();
    box = std::make_shared<const TriangleMesh>(make_box({1, 1, static_cast<double>(i)}));
    EXPECT_NEAR(kept.of(box, 1, volume), i, 1e-12);
  }
  EXPECT_NEAR(kept.of(other, 1, volume), 2, 1e-12);
  EXPECT_EQ(made, 3 + 8);
}

}  // namespace
}  // namespace prehend::geometry
