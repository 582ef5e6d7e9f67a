#pragma once

#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// The triangles round each vertex form one ring: following the edges opposite to it comes back
/// after all of them.
inline void expect_one_ring_per_vertex(const geometry::TriangleMesh& mesh) {
  std::vector<std::map<int, int>> next(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const bool is_new = next[t[k]].emplace(t[(k + 1) % 3], t[(k + 2) % 3]).second;
      ASSERT_TRUE(is_new) << "two triangles leave vertex " << t[k] << " along one edge";
    }
  }
  for (std::size_t vertex = 0; vertex < next.size(); ++vertex) {
    ASSERT_FALSE(next[vertex].empty()) << "vertex " << vertex << " has no triangle";
    std::size_t passed = 0;
    const int start = next[vertex].begin()->first;
    int at = start;
    do {
      const auto found = next[vertex].find(at);
      ASSERT_NE(found, next[vertex].end()) << "an open ring";
      at = found->second;
      ++passed;
    } while (at != start && passed <= next[vertex].size());
    ASSERT_EQ(passed, next[vertex].size()) << "two rings meet in vertex " << vertex;
  }
}

/// Closed, two opposite triangles on every edge, one ring per vertex, no triangle without area.
inline void expect_manifold(const geometry::TriangleMesh& mesh) {
  const geometry::MeshDefects defects = geometry::find_defects(mesh);
  ASSERT_TRUE(defects.watertight()) << defects.to_string();
  expect_one_ring_per_vertex(mesh);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    ASSERT_GT((mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a).norm(), 0);
  }
}

}  // namespace prehend::surface
