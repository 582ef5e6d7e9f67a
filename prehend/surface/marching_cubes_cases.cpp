#include "prehend/surface/marching_cubes_cases.h"

#include <cstddef>
#include <utility>

namespace prehend::surface {
namespace {

using Loop = std::vector<std::int8_t>;
using Triangle = std::array<std::int8_t, 3>;

// Corners of each face, counter-clockwise seen from outside the cube.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                              {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

int edge_between(int a, int b) {
  for (int e = 0; e < 12; ++e) {
    const int low = edge_corner(e);
    const int high = low | 1 << e / 4;
    if ((low == a && high == b) || (low == b && high == a)) return e;
  }
  return -1;
}

bool on_face(int edge, const int* face) {
  for (int k = 0; k < 4; ++k) {
    if (edge_between(face[k], face[(k + 1) % 4]) == edge) return true;
  }
  return false;
}

bool share_face(int a, int b) {
  for (const auto& face : kFaces) {
    if (on_face(a, face) && on_face(b, face)) return true;
  }
  return false;
}

/// The loops of crossed edges. Going round a face counter-clockwise, each run of inside corners is
/// cut off by a segment from where it is entered to where it is left; an edge is entered on one of
/// its two faces and left on the other, so the segments chain into loops.
std::vector<Loop> loops_of(int inside) {
  std::array<int, 12> next;
  next.fill(-1);
  for (const auto& face : kFaces) {
    const auto is_inside = [&](int k) { return (inside >> face[k % 4] & 1) != 0; };
    for (int k = 0; k < 4; ++k) {
      if (is_inside(k) || !is_inside(k + 1)) continue;  // a run starts at k + 1
      int end = k + 1;
      while (is_inside(end + 1)) ++end;
      const int entered = edge_between(face[k], face[(k + 1) % 4]);
      next[entered] = edge_between(face[end % 4], face[(end + 1) % 4]);
    }
  }
  std::vector<Loop> loops;
  for (int start = 0; start < 12; ++start) {
    if (next[start] < 0) continue;
    Loop loop;
    for (int e = start; next[e] >= 0;) {
      loop.push_back(static_cast<std::int8_t>(e));
      e = std::exchange(next[e], -1);
    }
    loops.push_back(loop);
  }
  return loops;
}

/// Cuts the polygon into triangles without a diagonal on a face; false when there is no such way.
bool triangulate(const Loop& polygon, std::vector<Triangle>& triangles) {
  const std::size_t n = polygon.size();
  if (n == 3) {
    triangles.push_back({polygon[0], polygon[1], polygon[2]});
    return true;
  }
  // Ears are cut off in turn, so that a strip comes out rather than a fan.
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t ear = (i + 1) % n;
    const std::int8_t before = polygon[i];
    const std::int8_t after = polygon[(i + 2) % n];
    if (share_face(before, after)) continue;
    Loop rest;
    for (std::size_t k = 1; k < n; ++k) rest.push_back(polygon[(ear + k) % n]);
    const std::size_t count = triangles.size();
    triangles.push_back({before, polygon[ear], after});
    if (triangulate(rest, triangles)) return true;
    triangles.resize(count);
  }
  return false;
}

CubeCase make_case(int inside) {
  CubeCase result;
  for (const Loop& loop : loops_of(inside)) {
    if (triangulate(loop, result.triangles)) continue;
    const auto center = static_cast<std::int8_t>(12 + result.centered.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      result.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], center});
    }
    result.centered.push_back(loop);
  }
  return result;
}

}  // namespace

int edge_corner(int e) {
  constexpr int kLow[12] = {0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3};
  return kLow[e];
}

const std::array<CubeCase, 256>& cube_cases() {
  static const std::array<CubeCase, 256> cases = [] {
    std::array<CubeCase, 256> all;
    for (int inside = 0; inside < 256; ++inside) all[inside] = make_case(inside);
    return all;
  }();
  return cases;
}

}  // namespace prehend::surface
