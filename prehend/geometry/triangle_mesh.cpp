#include "prehend/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include <LinearMath/btConvexHullComputer.h>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

// Both directions of one undirected edge, counted.
struct EdgeUse {
  int forward = 0;   // low index to high
  int backward = 0;  // high index to low
};

std::uint64_t edge_key(int a, int b) {
  const auto low = static_cast<std::uint64_t>(std::min(a, b));
  const auto high = static_cast<std::uint64_t>(std::max(a, b));
  return low << 32 | high;
}

bool is_degenerate(const Eigen::Vector3i& t, int vertex_count) {
  if (t.minCoeff() < 0 || t.maxCoeff() >= vertex_count) return true;
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

}  // namespace

std::string MeshDefects::to_string() const {
  std::string text;
  const auto add = [&text](int count, const char* name) {
    if (count == 0) return;
    if (!text.empty()) text += ", ";
    text += std::to_string(count) + " " + name;
  };
  add(boundary_edges, "boundary edges");
  add(non_manifold_edges, "non-manifold edges");
  add(flipped_edges, "flipped edges");
  add(degenerate_triangles, "degenerate triangles");
  return text.empty() ? "watertight" : text;
}

MeshDefects find_defects(const TriangleMesh& mesh) {
  MeshDefects defects;
  std::unordered_map<std::uint64_t, EdgeUse> edges;
  edges.reserve(mesh.triangles.size() * 2);
  const int vertex_count = static_cast<int>(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    if (is_degenerate(t, vertex_count)) {
      ++defects.degenerate_triangles;
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const int a = t[k];
      const int b = t[(k + 1) % 3];
      EdgeUse& use = edges[edge_key(a, b)];
      ++(a < b ? use.forward : use.backward);
    }
  }
  for (const auto& [key, use] : edges) {
    const int count = use.forward + use.backward;
    if (count == 1) {
      ++defects.boundary_edges;
    } else if (count > 2) {
      ++defects.non_manifold_edges;
    } else if (use.forward != use.backward) {
      ++defects.flipped_edges;
    }
  }
  return defects;
}

MassProperties mass_properties(const TriangleMesh& mesh) {
  MassProperties result;
  if (mesh.empty()) return result;
  // Relative to the first vertex, so that a mesh far from the origin loses no digits.
  const Eigen::Vector3d reference = mesh.vertices[mesh.triangles.front()[0]];
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]] - reference;
    const Eigen::Vector3d b = mesh.vertices[t[1]] - reference;
    const Eigen::Vector3d c = mesh.vertices[t[2]] - reference;
    // The signed tetrahedron (0, a, b, c): integrals of 1, x and x xT in closed form.
    const double v = a.dot(b.cross(c)) / 6;
    const Eigen::Vector3d s = a + b + c;
    volume += v;
    first += v / 4 * s;
    second +=
        v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  result.volume = volume;
  if (volume == 0) return result;
  const Eigen::Vector3d center = first / volume;
  result.center_of_mass = reference + center;
  const Eigen::Matrix3d covariance = second - volume * center * center.transpose();
  result.unit_density_inertia = covariance.trace() * Eigen::Matrix3d::Identity() - covariance;
  return result;
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t[0]];
    area += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm() / 2;
  }
  return area;
}

Eigen::AlignedBox3d bounds(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& v : mesh.vertices) box.extend(v);
  return box;
}

TriangleMesh transformed(const TriangleMesh& mesh_B, const RigidTransform& X_AB) {
  TriangleMesh mesh_A = mesh_B;
  for (auto& v : mesh_A.vertices) v = X_AB * v;
  return mesh_A;
}

TriangleMesh with_merged_vertices(const TriangleMesh& mesh, double tolerance) {
  if (!(tolerance > 0)) throw std::invalid_argument("tolerance of merged vertices must be > 0 m");
  TriangleMesh out;
  std::unordered_map<std::uint64_t, std::vector<int>> cells;
  const auto cell_of = [](const Eigen::Array3d& c) {
    const auto part = [](double x) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(x));
    };
    return part(c.x()) * 73856093ULL ^ part(c.y()) * 19349663ULL ^ part(c.z()) * 83492791ULL;
  };
  // Cells of one tolerance; a partner can only be in one of the 27 around.
  std::vector<int> new_index(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Array3d cell = (mesh.vertices[i].array() / tolerance).floor();
    int found = -1;
    for (int n = 0; n < 27 && found < 0; ++n) {
      const Eigen::Array3d neighbour = cell + Eigen::Array3d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      const auto it = cells.find(cell_of(neighbour));
      if (it == cells.end()) continue;
      for (int candidate : it->second) {
        if ((out.vertices[candidate] - mesh.vertices[i]).norm() <= tolerance) {
          found = candidate;
          break;
        }
      }
    }
    if (found < 0) {
      found = static_cast<int>(out.vertices.size());
      out.vertices.push_back(mesh.vertices[i]);
      cells[cell_of(cell)].push_back(found);
    }
    new_index[i] = found;
  }
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3i merged(new_index[t[0]], new_index[t[1]], new_index[t[2]]);
    if (!is_degenerate(merged, static_cast<int>(out.vertices.size()))) {
      out.triangles.push_back(merged);
    }
  }
  return out;
}

TriangleMesh concatenated(const std::vector<TriangleMesh>& meshes) {
  TriangleMesh out;
  for (const auto& mesh : meshes) {
    const int first = static_cast<int>(out.vertices.size());
    out.vertices.insert(out.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& t : mesh.triangles) {
      out.triangles.push_back(t + Eigen::Vector3i::Constant(first));
    }
  }
  return out;
}

TriangleMesh convex_hull(const std::vector<Eigen::Vector3d>& points) {
  const std::string mend = "Pass at least four finite points that do not lie in one plane";
  if (points.size() < 4) throw InputError("A convex hull of fewer than four points", mend);
  Eigen::AlignedBox3d box;
  for (const auto& p : points) {
    if (!p.allFinite()) throw InputError("A convex hull of points with NaN or infinity", mend);
    box.extend(p);
  }
  // Scaled to unit size: Bullet snaps coordinates to a grid of the points' extent.
  const double scale = box.sizes().maxCoeff();
  if (!(scale > 0)) throw InputError("A convex hull of coincident points", mend);
  std::vector<double> coordinates;
  coordinates.reserve(points.size() * 3);
  for (const auto& p : points) {
    for (int k = 0; k < 3; ++k) coordinates.push_back((p[k] - box.center()[k]) / scale);
  }
  btConvexHullComputer computer;
  computer.compute(coordinates.data(), 3 * sizeof(double), static_cast<int>(points.size()), 0, 0);

  TriangleMesh hull;
  for (int i = 0; i < computer.vertices.size(); ++i) {
    const auto& v = computer.vertices[i];
    hull.vertices.push_back(box.center() + scale * Eigen::Vector3d(v.x(), v.y(), v.z()));
  }
  // Faces are fans of their edges.
  for (int f = 0; f < computer.faces.size(); ++f) {
    const auto* start = &computer.edges[computer.faces[f]];
    const int apex = start->getSourceVertex();
    for (const auto* edge = start->getNextEdgeOfFace(); edge->getTargetVertex() != apex;
         edge = edge->getNextEdgeOfFace()) {
      hull.triangles.emplace_back(apex, edge->getSourceVertex(), edge->getTargetVertex());
    }
  }
  const double volume = mass_properties(hull).volume;
  if (!(std::abs(volume) > 1e-9 * scale * scale * scale)) {
    throw InputError("A convex hull of coplanar points", mend);
  }
  if (volume < 0) {
    for (auto& t : hull.triangles) std::swap(t[1], t[2]);
  }
  return hull;
}

}  // namespace prehend::geometry
