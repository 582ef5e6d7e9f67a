// Meshes that bound a solid but for pinched and folded places.

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "prehend/surface/edge_cuts.h"

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

// Two boxes that touch along an edge, whose corners are the same vertices.
TriangleMesh boxes_at_an_edge() {
  const TriangleMesh box = geometry::make_box({1, 1, 1});
  TriangleMesh other = box;
  for (Eigen::Vector3d& p : other.vertices) p += Eigen::Vector3d(1, 1, 0);
  return geometry::with_merged_vertices(geometry::concatenated({box, other}), 1e-9);
}

TEST(CutEdges, TwoBoxesThatShareAnEdgeBecomeTwoSolids) {
  const TriangleMesh pinched = boxes_at_an_edge();
  ASSERT_EQ(geometry::find_defects(pinched).non_manifold_edges, 1);
  const TriangleMesh cut = with_cut_edges(pinched);
  EXPECT_TRUE(geometry::find_defects(cut).watertight()) << geometry::find_defects(cut).to_string();
  EXPECT_NEAR(geometry::mass_properties(cut).volume, 2, 1e-12);
  EXPECT_NEAR(geometry::surface_area(cut), 12, 1e-12);
  for (const Eigen::Vector3i& t : cut.triangles) {
    EXPECT_GT(geometry::surface_area({cut.vertices, {t}}), 0.1);
  }
}

TEST(CutEdges, AFoldIsDropped) {
  TriangleMesh folded = geometry::make_box({1, 1, 1});
  const std::size_t before = folded.triangles.size();
  const Eigen::Vector3i edge = folded.triangles.front();
  const int tip = static_cast<int>(folded.vertices.size());
  folded.vertices.emplace_back(0, 0, 2);
  folded.triangles.emplace_back(edge.x(), edge.y(), tip);
  folded.triangles.emplace_back(tip, edge.y(), edge.x());
  ASSERT_FALSE(geometry::find_defects(folded).watertight());
  const TriangleMesh cut = with_cut_edges(folded);
  EXPECT_TRUE(geometry::find_defects(cut).watertight());
  EXPECT_EQ(cut.triangles.size(), before);
}

// All three edges of a triangle may be crowded.
TEST(CutEdges, ASolidGivenTwiceIsWatertightWithTwiceItsVolume) {
  const TriangleMesh box = geometry::make_box({1, 2, 3});
  TriangleMesh twice = box;
  twice.triangles.insert(twice.triangles.end(), box.triangles.begin(), box.triangles.end());
  const TriangleMesh cut = with_cut_edges(twice);
  EXPECT_TRUE(geometry::find_defects(cut).watertight()) << geometry::find_defects(cut).to_string();
  EXPECT_NEAR(geometry::mass_properties(cut).volume, 12, 1e-12);
}

TEST(CutEdges, AnOpenMeshStaysOpen) {
  TriangleMesh open = geometry::make_box({1, 1, 1});
  open.triangles.pop_back();
  const TriangleMesh same = with_cut_edges(open);
  EXPECT_EQ(same.triangles.size(), open.triangles.size());
  EXPECT_EQ(geometry::find_defects(same).boundary_edges, 3);
}

}  // namespace
}  // namespace prehend::surface
