#include "prehend/grasp/closing/distance_grid.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace prehend::grasp {
namespace {

constexpr double kMostNodes = 1e8;
constexpr int kCoarse = kBlockSide;  // nodes between those that tell how far is far

std::size_t index_of(const Eigen::Vector3i& count, int x, int y, int z) {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count.y()) +
          static_cast<std::size_t>(y)) *
             static_cast<std::size_t>(count.x()) +
         static_cast<std::size_t>(x);
}

static_assert(std::atomic_ref<std::uint32_t>::is_always_lock_free);

}  // namespace

DistanceGrid::LazyFloats::LazyFloats(std::size_t count)
    : bits_(static_cast<std::uint32_t*>(std::calloc(count, sizeof(std::uint32_t)))) {}

inline float DistanceGrid::LazyFloats::operator[](std::size_t i) const {
  const std::atomic_ref<std::uint32_t> bits(bits_[i]);
  return std::bit_cast<float>(~bits.load(std::memory_order_relaxed));
}

inline void DistanceGrid::LazyFloats::set(std::size_t i, float value) const {
  const std::atomic_ref<std::uint32_t> bits(bits_[i]);
  bits.store(~std::bit_cast<std::uint32_t>(value), std::memory_order_relaxed);
}

DistanceGrid::DistanceGrid(const geometry::SurfaceQuery& mesh, double cell, double margin)
    : mesh_(&mesh), cell_(cell), per_cell_(1 / cell) {
  if (!(cell > 0) || !std::isfinite(cell) || !(margin > 0) || !std::isfinite(margin)) {
    throw std::invalid_argument("DistanceGrid: cell and margin must be positive and finite");
  }
  for (const auto& t : mesh.mesh().triangles) {
    for (int k = 0; k < 3; ++k) box_.extend(mesh.mesh().vertices[static_cast<std::size_t>(t[k])]);
  }
  origin_ = box_.min().array() - margin;
  const Eigen::Vector3d size = box_.sizes().array() + 2 * margin;
  const Eigen::Array3d counts = (size / cell).array().ceil() + 2;
  count_.setZero();
  coarse_count_.setZero();
  if (!(counts.prod() <= kMostNodes)) return;
  count_ = counts.cast<int>();
  coarse_count_ = (count_.array() + kCoarse - 1) / kCoarse + 1;  // one beyond, to round to
  nodes_ = LazyFloats(static_cast<std::size_t>(count_.prod()));
  coarse_nodes_ = LazyFloats(static_cast<std::size_t>(coarse_count_.prod()));
  if (!nodes_ || !coarse_nodes_) {
    nodes_ = {};
    return;
  }
  blocks_.emplace(mesh);
}

double DistanceGrid::coarse_node(int x, int y, int z) const {
  const std::size_t index = index_of(coarse_count_, x, y, z);
  float value = coarse_nodes_[index];
  if (std::isnan(value)) {
    const auto found = mesh_->nearest(origin_ + kCoarse * cell_ * Eigen::Vector3d(x, y, z));
    value = static_cast<float>(found ? found->distance : 1e9);
    coarse_nodes_.set(index, value);
  }
  return value;
}

double DistanceGrid::node(int x, int y, int z) const {
  const std::size_t index = index_of(count_, x, y, z);
  const float value = nodes_[index];
  if (!std::isnan(value)) return value;
  fill_block({x / kBlockSide, y / kBlockSide, z / kBlockSide});
  return nodes_[index];
}

void DistanceGrid::fill_block(const Eigen::Vector3i& block) const {
  const Eigen::Vector3i first = kBlockSide * block;
  // Its middle is not farther than its first node, a coarse one, and the way from there.
  const double way = std::sqrt(3.0) * (kBlockSide - 1) / 2 * cell_;
  const double most = coarse_node(block.x(), block.y(), block.z()) + way;
  const DistanceBlock distances =
      blocks_->measure(origin_ + cell_ * first.cast<double>(), cell_, most);
  const Eigen::Vector3i size = (count_ - first).cwiseMin(kBlockSide);
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      const std::size_t row = index_of(count_, first.x(), first.y() + y, first.z() + z);
      for (int x = 0; x < size.x(); ++x) {
        const auto from = static_cast<std::size_t>((z * kBlockSide + y) * kBlockSide + x);
        nodes_.set(row + static_cast<std::size_t>(x), distances[from]);
      }
    }
  }
}

bool DistanceGrid::find_cell(const Eigen::Vector3d& p, Cell& cell) const {
  const double x = (p.x() - origin_.x()) * per_cell_, y = (p.y() - origin_.y()) * per_cell_,
               z = (p.z() - origin_.z()) * per_cell_;
  if (!(x >= 0 && y >= 0 && z >= 0 && x < count_.x() - 1 && y < count_.y() - 1 &&
        z < count_.z() - 1)) {
    return false;
  }
  cell.x = static_cast<int>(x);
  cell.y = static_cast<int>(y);
  cell.z = static_cast<int>(z);
  cell.part_x = x - cell.x;
  cell.part_y = y - cell.y;
  cell.part_z = z - cell.z;
  return true;
}

void DistanceGrid::corners(const Cell& cell, double (&values)[8]) const {
  const std::size_t from = index_of(count_, cell.x, cell.y, cell.z);
  const auto row = static_cast<std::size_t>(count_.x());
  const auto layer = row * static_cast<std::size_t>(count_.y());
  const std::size_t offsets[8] = {0,     1,         row,         row + 1,
                                  layer, layer + 1, layer + row, layer + row + 1};
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    values[corner] = nodes_[from + offsets[corner]];
    sum += values[corner];
  }
  if (!std::isnan(sum)) return;
  for (int corner = 0; corner < 8; ++corner) {
    values[corner] =
        node(cell.x + (corner & 1), cell.y + ((corner >> 1) & 1), cell.z + (corner >> 2));
  }
}

double DistanceGrid::distance(const Eigen::Vector3d& p) const {
  Cell cell;
  if (!nodes_ || !find_cell(p, cell)) {
    const double outside = box_.exteriorDistance(p);
    if (outside > kNear) return outside;
    const auto found = mesh_->nearest(p);
    return found ? found->distance : std::numeric_limits<double>::infinity();
  }
  // What a coarse node tells: nobody is nearer than its distance less the way to it.
  const double x = cell.x + cell.part_x, y = cell.y + cell.part_y, z = cell.z + cell.part_z;
  const int cx = static_cast<int>(x / kCoarse + 0.5), cy = static_cast<int>(y / kCoarse + 0.5),
            cz = static_cast<int>(z / kCoarse + 0.5);
  const double dx = x - kCoarse * cx, dy = y - kCoarse * cy, dz = z - kCoarse * cz;
  const double squared_way = cell_ * cell_ * (dx * dx + dy * dy + dz * dz);
  const double coarse = coarse_node(cx, cy, cz), beyond = coarse - kNear;
  if (beyond > 0 && beyond * beyond > squared_way) return coarse - std::sqrt(squared_way);
  double v[8];
  corners(cell, v);
  const double x00 = v[0] + cell.part_x * (v[1] - v[0]), x10 = v[2] + cell.part_x * (v[3] - v[2]);
  const double x01 = v[4] + cell.part_x * (v[5] - v[4]), x11 = v[6] + cell.part_x * (v[7] - v[6]);
  const double y0 = x00 + cell.part_y * (x10 - x00), y1 = x01 + cell.part_y * (x11 - x01);
  return y0 + cell.part_z * (y1 - y0);
}

Eigen::Vector3d DistanceGrid::away(const Eigen::Vector3d& p) const {
  Cell cell;
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
  if (nodes_ && find_cell(p, cell)) {
    double v[8];
    corners(cell, v);
    const double parts[3] = {cell.part_x, cell.part_y, cell.part_z};
    for (int corner = 0; corner < 8; ++corner) {
      for (int k = 0; k < 3; ++k) {
        double weight = (corner >> k) & 1 ? 1 : -1;
        for (int other = 0; other < 3; ++other) {
          if (other != k) weight *= (corner >> other) & 1 ? parts[other] : 1 - parts[other];
        }
        slope[k] += weight * v[corner];
      }
    }
  } else if (const auto found = mesh_->nearest(p)) {
    slope = p - found->point;
  }
  const double length = slope.norm();
  return length > 1e-12 ? Eigen::Vector3d(slope / length) : Eigen::Vector3d::Zero();
}

}  // namespace prehend::grasp
