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
constexpr std::uint8_t kHasSeen = 1;
constexpr std::uint8_t kHasPredicted = 2;

/// Which kinds of points each cell holds.
class Cells {
 public:
  Cells(const shape::CompletedShape& shape, double side) : side_(side) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3f& p : shape.cloud_W.points) box.extend(p.cast<double>());
    if (!(side > 0) || !(box.sizes().maxCoeff() < kMostCells * side)) {
      throw std::invalid_argument("vertex_origins: spacing must be > 0 and fit the shape");
    }
    low_ = box.min();
    for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
      const bool seen = shape.origin[i] == shape::PointOrigin::kSeen;
      kinds_[key(cell_of(shape.cloud_W.points[i].cast<double>()))] |=
          seen ? kHasSeen : kHasPredicted;
    }
  }

  SurfaceOrigin at(const Eigen::Vector3d& p) const {
    const Eigen::Vector3i center = cell_of(p);
    if ((center.array() < -kReach).any() || (center.array() > kMostCells + kReach).any()) {
      return SurfaceOrigin::kAssumed;
    }
    // Seen points may be two cells apart where the surface is oblique, predicted ones between them.
    const std::uint8_t near = in_ring(center, 0) | in_ring(center, 1);
    if (near & kHasSeen) return SurfaceOrigin::kSeen;
    if (near != 0) return SurfaceOrigin::kPredicted;
    const std::uint8_t around = in_ring(center, kReach);
    if (around & kHasSeen) return SurfaceOrigin::kSeen;
    if (around != 0) return SurfaceOrigin::kPredicted;
    return SurfaceOrigin::kAssumed;
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
  /// The kinds in the cells that are `ring` away along some axis and no farther along the others.
  std::uint8_t in_ring(const Eigen::Vector3i& center, int ring) const {
    std::uint8_t kinds = 0;
    for (int z = -ring; z <= ring; ++z) {
      for (int y = -ring; y <= ring; ++y) {
        const bool on_side = std::abs(z) == ring || std::abs(y) == ring;
        for (int x = -ring; x <= ring; x += on_side ? 1 : 2 * ring) {
          const auto found = kinds_.find(key(center + Eigen::Vector3i(x, y, z)));
          if (found != kinds_.end()) kinds |= found->second;
        }
      }
    }
    return kinds;
  }

  double side_;
  Eigen::Vector3d low_;
  std::unordered_map<std::uint64_t, std::uint8_t> kinds_;
};

}  // namespace

std::vector<SurfaceOrigin> vertex_origins(const geometry::TriangleMesh& mesh_W,
                                          const shape::CompletedShape& shape, double spacing) {
  const Cells cells(shape, spacing);
  std::vector<SurfaceOrigin> origins;
  origins.reserve(mesh_W.vertices.size());
  for (const Eigen::Vector3d& vertex : mesh_W.vertices) origins.push_back(cells.at(vertex));
  return origins;
}

double guessed_area(const geometry::TriangleMesh& mesh, const std::vector<SurfaceOrigin>& origins) {
  double guessed = 0;
  double whole = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    const double area = (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a).norm();
    for (const int i : t) guessed += origins[i] == SurfaceOrigin::kSeen ? 0 : area / 3;
    whole += area;
  }
  return whole > 0 ? guessed / whole : 0;
}

}  // namespace prehend::surface
