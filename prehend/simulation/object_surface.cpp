#include "prehend/simulation/object_surface.h"

#include <algorithm>
#include <cmath>

#include "prehend/simulation/mesh_surface.h"

namespace prehend::simulation {
namespace {

constexpr double kCell = 0.005;  // m, of the grid of what is near
constexpr int kMostCells = 40;   // along each side

/// Whether more than a few points of its surface have the other side of a wall behind them.
bool has_thin_walls(const BodyModel& model) {
  constexpr double kFewPoints = 0.05, kOff = 1e-6;  // share; m
  const std::vector<Eigen::Vector3d> normals =
      normals_at(model.surface_points, *model.mesh, model.query);
  std::size_t thin = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (normals[i].isZero(0)) continue;
    const Eigen::Vector3d inward = -normals[i];
    const auto other_side = model.query->cast_ray(model.surface_points[i] + kOff * inward, inward,
                                                  ObjectSurface::kThinWall);
    thin += other_side && other_side->normal.dot(inward) > 0;
  }
  return static_cast<double>(thin) > kFewPoints * static_cast<double>(normals.size());
}

}  // namespace

ObjectSurface::ObjectSurface(const BodyModel& model) : felt_(model.felt), query_(model.query) {
  if (felt_.shape.kind() != contact::Shape::Kind::kMesh) return;
  has_thin_walls_ = has_thin_walls(model);
  box_ = model.box;
  side_ = std::max(kCell, model.box.sizes().maxCoeff() / kMostCells);
  box_.min().array() -= 1.5 * side_;
  box_.max().array() += 1.5 * side_;
  cells_ = (box_.sizes() / side_).array().ceil().cast<int>();
  clearance_.assign(static_cast<std::size_t>(cells_.prod()), 0);
  // Points are asked for within a millimetre or two of the surface, or inside.
  const double reach = 0.5 * std::sqrt(3.0) * side_ + 0.003;
  std::size_t k = 0;
  for (int z = 0; z < cells_.z(); ++z) {
    for (int y = 0; y < cells_.y(); ++y) {
      for (int x = 0; x < cells_.x(); ++x, ++k) {
        const Eigen::Vector3d center =
            box_.min() + side_ * (Eigen::Vector3d(x, y, z).array() + 0.5).matrix();
        if (model.box.contains(center) && model.query->contains(center)) continue;
        const auto nearest = model.query->nearest(center, reach);
        // A little less, as floats round.
        clearance_[k] = static_cast<float>((nearest ? nearest->distance : reach) * (1 - 1e-6));
      }
    }
  }
}

double ObjectSurface::outside_by(const Eigen::Vector3d& p_B) const {
  const Eigen::Vector3d cell = (p_B - box_.min()) / side_;
  if (!(cell.minCoeff() >= 0)) return kDeepest;
  const Eigen::Vector3i i = cell.cast<int>();
  if ((i.array() >= cells_.array()).any()) return kDeepest;
  const double clear = static_cast<double>(
      clearance_[static_cast<std::size_t>(i.x() + cells_.x() * (i.y() + cells_.y() * i.z()))]);
  // On the way from the cell's middle the surface is not crossed.
  const double way = side_ * (cell - i.cast<double>() - Eigen::Vector3d::Constant(0.5)).norm();
  return std::max(0.0, clear - way);
}

std::optional<Depth> ObjectSurface::at(const Eigen::Vector3d& p_B, double margin) const {
  Depth found;
  if (felt_.shape.kind() != contact::Shape::Kind::kMesh) {
    found.depth = felt_.shape.depth_inside(felt_.X_BS.inverse(Eigen::Isometry) * p_B, found.normal);
    found.normal = felt_.X_BS.linear() * found.normal;
    if (found.depth > 0 && found.depth < kDeepest) return found;
    return std::nullopt;
  }
  const double outside = outside_by(p_B);
  if (outside > margin) return std::nullopt;
  const double reach = outside > 0 ? margin : kDeepest;
  if (!mesh_depth(*query_, p_B, reach, found.normal, found.depth)) return std::nullopt;
  if (found.depth > -margin) return found;
  return std::nullopt;
}

std::optional<Depth> ObjectSurface::met_by(const Eigen::Vector3d& p_B,
                                           const Eigen::Vector3d& outward_B, double margin) const {
  const std::optional<Depth> nearest = at(p_B, margin);
  // The far side of a wall, from within it or beyond it.
  const bool beyond = has_thin_walls_ && !outward_B.isZero(0) && outside_by(p_B) < kThinWall &&
                      (!nearest || nearest->normal.dot(outward_B) > 0);
  return beyond ? wall_within(p_B, outward_B) : nearest;
}

std::optional<Depth> ObjectSurface::wall_within(const Eigen::Vector3d& p_B,
                                                const Eigen::Vector3d& outward_B) const {
  constexpr double kOff = 1e-7;  // m, past a face that was met
  const Eigen::Vector3d inward = -outward_B;
  double way = 0;
  std::optional<Depth> found;
  while (way < kThinWall) {
    const auto hit = query_->cast_ray(p_B + way * inward, inward, kThinWall - way);
    if (!hit) break;
    way += hit->distance + kOff;
    const double along = hit->normal.dot(inward);
    if (along <= 0) continue;  // into a wall
    found = Depth{hit->normal, way * along};
  }
  return found;
}

}  // namespace prehend::simulation
