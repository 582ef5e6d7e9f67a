#include "prehend/surface/edge_cuts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

/// A triangle by its corners in order, and whether that turns it round.
struct Face {
  std::array<int, 3> corners;
  bool turned = false;
  std::size_t triangle = 0;
};

Face face_of(const Eigen::Vector3i& t, std::size_t triangle) {
  Face face{{t.x(), t.y(), t.z()}, false, triangle};
  std::rotate(face.corners.begin(), std::min_element(face.corners.begin(), face.corners.end()),
              face.corners.end());
  if (face.corners[1] > face.corners[2]) {
    std::swap(face.corners[1], face.corners[2]);
    face.turned = true;
  }
  return face;
}

TriangleMesh without_folds(const TriangleMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    faces.push_back(face_of(mesh.triangles[i], i));
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return std::tie(a.corners, a.turned, a.triangle) < std::tie(b.corners, b.turned, b.triangle);
  });
  std::vector<bool> dropped(mesh.triangles.size(), false);
  for (auto first = faces.begin(); first != faces.end();) {
    const auto turned = std::find_if(first, faces.end(), [&](const Face& face) {
      return face.corners != first->corners || face.turned;
    });
    const auto end = std::find_if(turned, faces.end(),
                                  [&](const Face& face) { return face.corners != first->corners; });
    for (auto one = first, other = turned; one != turned && other != end; ++one, ++other) {
      dropped[one->triangle] = dropped[other->triangle] = true;
    }
    first = end;
  }
  TriangleMesh result{mesh.vertices, {}};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!dropped[i]) result.triangles.push_back(mesh.triangles[i]);
  }
  return result;
}

/// The edge of a triangle from its corner `k` to the next.
struct HalfEdge {
  int low = 0;
  int high = 0;
  bool backward = false;  // from high to low
  std::size_t triangle = 0;
  int k = 0;
};

std::vector<HalfEdge> sorted_half_edges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a > b, i, k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.backward, a.triangle) <
           std::tie(b.low, b.high, b.backward, b.triangle);
  });
  return edges;
}

constexpr int kNoMiddle = -1;
using Middles = std::array<int, 3>;  // vertices in the middle of a triangle's edges, or kNoMiddle

/// Adds a vertex for each pair of triangles at an edge that has more than two.
std::vector<Middles> cut_crowded_edges(TriangleMesh& mesh) {
  std::vector<Middles> middles(mesh.triangles.size(), {kNoMiddle, kNoMiddle, kNoMiddle});
  const std::vector<HalfEdge> edges = sorted_half_edges(mesh);
  for (auto first = edges.begin(); first != edges.end();) {
    const auto other_edge = [&](const HalfEdge& edge) {
      return edge.low != first->low || edge.high != first->high;
    };
    const auto end = std::find_if(first, edges.end(), other_edge);
    const auto backward =
        std::find_if(first, end, [](const HalfEdge& edge) { return edge.backward; });
    const bool crowded = end - first > 2;
    for (auto one = first, back = backward; crowded && one != backward && back != end;
         ++one, ++back) {
      const int middle = static_cast<int>(mesh.vertices.size());
      mesh.vertices.push_back((mesh.vertices[one->low] + mesh.vertices[one->high]) / 2);
      middles[one->triangle][one->k] = middles[back->triangle][back->k] = middle;
    }
    first = end;
  }
  return middles;
}

}  // namespace

TriangleMesh with_cut_edges(const TriangleMesh& mesh) {
  TriangleMesh whole = without_folds(mesh);
  const std::vector<Middles> middles = cut_crowded_edges(whole);
  TriangleMesh result;
  for (std::size_t i = 0; i < whole.triangles.size(); ++i) {
    std::vector<int> outline;
    auto hub = outline.size();  // a middle is on one edge only, so no triangle from it is flat
    for (int k = 0; k < 3; ++k) {
      outline.push_back(whole.triangles[i][k]);
      if (middles[i][k] == kNoMiddle) continue;
      hub = outline.size();
      outline.push_back(middles[i][k]);
    }
    std::rotate(outline.begin(), outline.begin() + static_cast<std::ptrdiff_t>(hub), outline.end());
    for (std::size_t k = 2; k < outline.size(); ++k) {
      result.triangles.emplace_back(outline[0], outline[k - 1], outline[k]);
    }
  }
  result.vertices = std::move(whole.vertices);
  return result;
}

}  // namespace prehend::surface
