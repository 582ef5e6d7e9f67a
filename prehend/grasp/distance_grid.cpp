#include "prehend/grasp/distance_grid.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace prehend::grasp {
namespace {

constexpr double kMostNodes = 8e6;
constexpr int kCoarse = 4;  // nodes between those that tell how far is far

}  // namespace

DistanceGrid::DistanceGrid(const geometry::MeshQuery& mesh, double cell, double margin)
    : mesh_(&mesh), cell_(cell) {
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
  if (!(counts.prod() <= kMostNodes)) return;
  count_ = counts.cast<int>();
  const std::size_t total = static_cast<std::size_t>(count_.prod());
  nodes_ = std::make_unique<std::atomic<float>[]>(total);
  for (std::size_t i = 0; i < total; ++i) {
    nodes_[i].store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
  }
}

double DistanceGrid::node(int x, int y, int z) const {
  auto& stored = nodes_[(static_cast<std::size_t>(z) * static_cast<std::size_t>(count_.y()) +
                         static_cast<std::size_t>(y)) *
                            static_cast<std::size_t>(count_.x()) +
                        static_cast<std::size_t>(x)];
  float value = stored.load(std::memory_order_relaxed);
  if (std::isnan(value)) {
    const auto found = mesh_->nearest(origin_ + cell_ * Eigen::Vector3d(x, y, z));
    value = static_cast<float>(found ? found->distance : 1e9);
    stored.store(value, std::memory_order_relaxed);
  }
  return value;
}

bool DistanceGrid::find_cell(const Eigen::Vector3d& p, Cell& cell) const {
  const Eigen::Vector3d at = (p - origin_) / cell_;
  for (int k = 0; k < 3; ++k) {
    if (!(at[k] >= 0 && at[k] < count_[k] - 1)) return false;
    cell.node[k] = static_cast<int>(at[k]);
    cell.part[k] = at[k] - cell.node[k];
  }
  return true;
}

void DistanceGrid::corners(const Cell& cell, double (&values)[8]) const {
  for (int corner = 0; corner < 8; ++corner) {
    values[corner] = node(cell.node.x() + (corner & 1), cell.node.y() + ((corner >> 1) & 1),
                          cell.node.z() + (corner >> 2));
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
  Eigen::Vector3i coarse;
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double at = cell.node[k] + cell.part[k];
    coarse[k] = kCoarse * static_cast<int>(at / kCoarse + 0.5);
    if (coarse[k] >= count_[k]) coarse[k] -= kCoarse;
    squared += (at - coarse[k]) * (at - coarse[k]);
  }
  const double bound = node(coarse.x(), coarse.y(), coarse.z()) - cell_ * std::sqrt(squared);
  if (bound > kNear) return bound;
  double v[8];
  corners(cell, v);
  const Eigen::Vector3d& t = cell.part;
  const double x00 = v[0] + t.x() * (v[1] - v[0]), x10 = v[2] + t.x() * (v[3] - v[2]);
  const double x01 = v[4] + t.x() * (v[5] - v[4]), x11 = v[6] + t.x() * (v[7] - v[6]);
  const double y0 = x00 + t.y() * (x10 - x00), y1 = x01 + t.y() * (x11 - x01);
  return y0 + t.z() * (y1 - y0);
}

Eigen::Vector3d DistanceGrid::away(const Eigen::Vector3d& p) const {
  Cell cell;
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();
  if (nodes_ && find_cell(p, cell)) {
    double v[8];
    corners(cell, v);
    const Eigen::Vector3d& t = cell.part;
    for (int corner = 0; corner < 8; ++corner) {
      for (int k = 0; k < 3; ++k) {
        double weight = (corner >> k) & 1 ? 1 : -1;
        for (int other = 0; other < 3; ++other) {
          if (other != k) weight *= (corner >> other) & 1 ? t[other] : 1 - t[other];
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
