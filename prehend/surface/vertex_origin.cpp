#include "prehend/surface/vertex_origin.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <unordered_map>

#include <Eigen/Geometry>

namespace prehend::surface {
namespace {

constexpr int kReach = 2;           // cells
constexpr double kMostCells = 1e4;  // along an axis
constexpr float kNone = -1;         // confidence where there is no point

/// The surest seen and the surest predicted point of some cells.
struct Surest {
  float seen = kNone;
  float predicted = kNone;

  void add(const Surest& other) {
    seen = std::max(seen, other.seen);
    predicted = std::max(predicted, other.predicted);
  }
  bool empty() const { return seen == kNone && predicted == kNone; }
};

struct Basis {
  SurfaceOrigin origin;
  float confidence;
};

/// Which kinds of points each cell holds.
class Cells {
 public:
  Cells(const shape::CompletedShape& shape, double side)
      : side_(side), assumed_(static_cast<float>(shape.confidence / 2)) {
    if (shape.point_confidence.size() != shape.cloud_W.size()) {
      throw std::invalid_argument("vertex_basis: the shape needs a confidence for each point");
    }
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3f& p : shape.cloud_W.points) box.extend(p.cast<double>());
    if (!(side > 0) || !(box.sizes().maxCoeff() < kMostCells * side)) {
      throw std::invalid_argument("vertex_basis: spacing must be > 0 and fit the shape");
    }
    low_ = box.min();
    for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
      const bool seen = shape.origin[i] == shape::PointOrigin::kSeen;
      const float sure = shape.point_confidence[i];
      cells_[key(cell_of(shape.cloud_W.points[i].cast<double>()))].add(seen ? Surest{sure, kNone}
                                                                            : Surest{kNone, sure});
    }
  }

  Basis at(const Eigen::Vector3d& p) const {
    const Basis assumed{SurfaceOrigin::kAssumed, assumed_};
    const Eigen::Vector3i center = cell_of(p);
    if ((center.array() < -kReach).any() || (center.array() > kMostCells + kReach).any()) {
      return assumed;
    }
    // Seen points may be two cells apart where the surface is oblique, predicted ones between them.
    Surest near = in_ring(center, 0);
    near.add(in_ring(center, 1));
    if (near.empty()) near = in_ring(center, kReach);
    if (near.seen != kNone) return {SurfaceOrigin::kSeen, near.seen};
    if (near.predicted != kNone) return {SurfaceOrigin::kPredicted, near.predicted};
    return assumed;
  }

 private:
  Eigen::Vector3i cell_of(const Eigen::Vector3d& p) const {
    const Eigen::Array3d cell = ((p - low_).array() / side_).floor();
    return cell.max(-1e6).min(1e6).cast<int>().matrix();
  }
  static std::uint64_t key(const Eigen::Vector3i& cell) {
    std::uint64_t result = 0;
    for (int axis = 0; axis < 3; ++axis) {
      result = result << 20 | static_cast<std::uint64_t>(cell[axis] + 16);
    }
    return result;
  }
  /// Of the cells that are `ring` away along some axis and no farther along the others.
  Surest in_ring(const Eigen::Vector3i& center, int ring) const {
    Surest surest;
    for (int z = -ring; z <= ring; ++z) {
      for (int y = -ring; y <= ring; ++y) {
        const bool on_side = std::abs(z) == ring || std::abs(y) == ring;
        for (int x = -ring; x <= ring; x += on_side ? 1 : 2 * ring) {
          const auto found = cells_.find(key(center + Eigen::Vector3i(x, y, z)));
          if (found != cells_.end()) surest.add(found->second);
        }
      }
    }
    return surest;
  }

  double side_;
  float assumed_;
  Eigen::Vector3d low_;
  std::unordered_map<std::uint64_t, Surest> cells_;
};

}  // namespace

VertexBasis vertex_basis(const geometry::TriangleMesh& mesh_W, const shape::CompletedShape& shape,
                         double spacing) {
  const Cells cells(shape, spacing);
  VertexBasis basis;
  basis.origin.reserve(mesh_W.vertices.size());
  basis.confidence.reserve(mesh_W.vertices.size());
  for (const Eigen::Vector3d& vertex : mesh_W.vertices) {
    const Basis at = cells.at(vertex);
    basis.origin.push_back(at.origin);
    basis.confidence.push_back(at.confidence);
  }
  return basis;
}

double guessed_area(const geometry::TriangleMesh& mesh, const std::vector<SurfaceOrigin>& origins) {
  double guessed = 0;
  double whole = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    const double area = (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a).norm();
    for (const int i : t) guessed += is_guessed(origins[i]) ? area / 3 : 0;
    whole += area;
  }
  return whole > 0 ? guessed / whole : 0;
}

}  // namespace prehend::surface
