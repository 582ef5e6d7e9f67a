#include "prehend/geometry/triangle_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <LinearMath/btConvexHullComputer.h>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

// An edge of a triangle at its end of the lower index.
struct EdgeEnd {
  int other = 0;         // the vertex of the higher index
  bool forward = false;  // the triangle runs from low to high
};

// The edges of all triangles, sorted by their lower vertex: those of vertex v are
// ends[first[v]] ... ends[first[v + 1] - 1].
struct Edges {
  std::vector<std::size_t> first;
  std::vector<EdgeEnd> ends;
};

bool is_degenerate(const Eigen::Vector3i& t, int vertex_count) {
  if (t.minCoeff() < 0 || t.maxCoeff() >= vertex_count) return true;
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// By counting, which takes a tenth of the time of a hash table for a mesh of millions.
Edges sorted_edges(const TriangleMesh& mesh) {
  const int vertex_count = static_cast<int>(mesh.vertices.size());
  Edges edges;
  edges.first.assign(mesh.vertices.size() + 2, 0);
  const auto for_each_edge = [&](const auto& work) {
    for (const Eigen::Vector3i& t : mesh.triangles) {
      if (is_degenerate(t, vertex_count)) continue;
      for (int k = 0; k < 3; ++k) work(t[k], t[(k + 1) % 3]);
    }
  };
  // Counted two places on, so that filling in moves the starts to where they belong.
  for_each_edge([&](int a, int b) { ++edges.first[std::min(a, b) + 2]; });
  for (std::size_t v = 2; v < edges.first.size(); ++v) edges.first[v] += edges.first[v - 1];
  edges.ends.resize(edges.first.back());
  for_each_edge([&](int a, int b) {
    edges.ends[edges.first[std::min(a, b) + 1]++] = {std::max(a, b), a < b};
  });
  return edges;
}

// Finds points again that are within a tolerance, by cells of some tolerances: most points are so
// far from their cell's border that no other cell can have their partner.
class MergedPoints {
 public:
  MergedPoints(std::size_t most, double tolerance)
      : tolerance_(tolerance), newest_(std::bit_ceil(most + 1), -1) {
    older_.reserve(most);
  }

  /// The index in `points` of one within the tolerance of `p`, which is appended if there is none.
  int index_of(const Eigen::Vector3d& p, std::vector<Eigen::Vector3d>& points) {
    const Eigen::Array3d low = cell_of(p.array() - tolerance_);
    const Eigen::Array3i more = (cell_of(p.array() + tolerance_) > low).cast<int>();
    for (int x = 0; x <= more.x(); ++x) {
      for (int y = 0; y <= more.y(); ++y) {
        for (int z = 0; z <= more.z(); ++z) {
          for (int i = newest_[slot(low + Eigen::Array3d(x, y, z))]; i >= 0; i = older_[i]) {
            if ((points[i] - p).squaredNorm() <= tolerance_ * tolerance_) return i;
          }
        }
      }
    }
    int& newest = newest_[slot(cell_of(p.array()))];
    older_.push_back(newest);
    newest = static_cast<int>(points.size());
    points.push_back(p);
    return newest;
  }

 private:
  static constexpr double kTolerancesAcross = 64;

  Eigen::Array3d cell_of(const Eigen::Array3d& p) const {
    return (p / (kTolerancesAcross * tolerance_)).floor();
  }
  // Cells that share a slot only cost a few comparisons.
  std::size_t slot(const Eigen::Array3d& cell) const {
    const auto part = [](double x) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(x));
    };
    std::uint64_t hash = part(cell.x()) * 0x9E3779B97F4A7C15ULL;
    hash = (hash ^ hash >> 32 ^ part(cell.y())) * 0xBF58476D1CE4E5B9ULL;
    hash = (hash ^ hash >> 32 ^ part(cell.z())) * 0x94D049BB133111EBULL;
    return (hash ^ hash >> 32) & (newest_.size() - 1);
  }

  double tolerance_;
  std::vector<int> newest_;  // of a slot's points, -1: none
  std::vector<int> older_;   // the one before it in its slot, -1: none
};

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
  const int vertex_count = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (is_degenerate(t, vertex_count)) ++defects.degenerate_triangles;
  }
  Edges edges = sorted_edges(mesh);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto end = edges.ends.begin() + static_cast<std::ptrdiff_t>(edges.first[v + 1]);
    auto one = edges.ends.begin() + static_cast<std::ptrdiff_t>(edges.first[v]);
    std::sort(one, end, [](const EdgeEnd& a, const EdgeEnd& b) { return a.other < b.other; });
    while (one != end) {
      int forward = 0, backward = 0;
      for (const int other = one->other; one != end && one->other == other; ++one) {
        ++(one->forward ? forward : backward);
      }
      if (forward + backward == 1) {
        ++defects.boundary_edges;
      } else if (forward + backward > 2) {
        ++defects.non_manifold_edges;
      } else if (forward != backward) {
        ++defects.flipped_edges;
      }
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

std::vector<Eigen::Vector3d> vertex_normals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    const Eigen::Vector3d twice = (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a);
    for (const int i : t) normals[i] += twice;
  }
  for (Eigen::Vector3d& normal : normals) {
    if (normal.norm() > 0) normal.normalize();
  }
  return normals;
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
  out.vertices.reserve(mesh.vertices.size());
  out.triangles.reserve(mesh.triangles.size());
  MergedPoints points(mesh.vertices.size(), tolerance);
  std::vector<int> new_index(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    new_index[i] = points.index_of(mesh.vertices[i], out.vertices);
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
