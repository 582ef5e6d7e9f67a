#include "prehend/planning/posed_hand.h"

#include <algorithm>
#include <limits>

namespace prehend::planning {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kTouching = 2e-4;  // m

geometry::TriangleMesh joined(const std::vector<geometry::TriangleMesh>& meshes) {
  geometry::TriangleMesh all;
  for (const geometry::TriangleMesh& mesh : meshes) {
    const auto first = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& t : mesh.triangles) {
      all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  return all;
}

}  // namespace

PosedHand::PosedHand(const robot::Platform& platform, const grasp::HandToClose& hand,
                     const robot::Preshape& preshape, const Eigen::VectorXd& motors,
                     const geometry::TriangleMesh& object_W, const PlatformScene& scene)
    : hand_(hand),
      all_(platform.hand.all_positions(motors)),
      X_GH_((platform.hand.X_HP * preshape.X_PG).inverse(Eigen::Isometry)),
      object_(object_W),
      object_grid_(object_),
      obstacles_(joined(scene.obstacle_pieces_W)),
      scene_{&object_grid_, scene.table_W, nullptr} {
  hand.hand->link_poses(all_, X_HL_);
  if (obstacles_.triangles.empty()) return;
  obstacle_query_.emplace(obstacles_);
  obstacle_grid_.emplace(*obstacle_query_);
  scene_.obstacles_W = &*obstacle_grid_;
}

bool PosedHand::is_of(int link, int finger) const {
  const std::vector<int>& links = hand_.hand->fingers.at(static_cast<std::size_t>(finger)).links;
  return std::find(links.begin(), links.end(), link) != links.end();
}

void PosedHand::extend(int link, const Vector3d& d_H, double* most, Vector3d* best_H) const {
  const auto l = static_cast<std::size_t>(link);
  const grasp::LinkBalls& balls = hand_.balls.links[l];
  for (std::size_t i = 0; i < balls.centers.size(); ++i) {
    const Vector3d front_H = X_HL_[l] * balls.centers[i] + balls.radii[i] * d_H;
    if (front_H.dot(d_H) <= *most) continue;
    *most = front_H.dot(d_H);
    *best_H = front_H;
  }
}

Vector3d PosedHand::foremost(int finger, const Vector3d& d_G) const {
  const Vector3d d_H = X_GH_.linear().transpose() * d_G;
  double most = -std::numeric_limits<double>::infinity();
  Vector3d best_H = Vector3d::Zero();
  for (const int link : hand_.hand->fingers.at(static_cast<std::size_t>(finger)).links) {
    extend(link, d_H, &most, &best_H);
  }
  return X_GH_ * best_H;
}

Vector3d PosedHand::foremost(const Vector3d& d_G) const {
  const Vector3d d_H = X_GH_.linear().transpose() * d_G;
  double most = -std::numeric_limits<double>::infinity();
  Vector3d best_H = Vector3d::Zero();
  for (std::size_t l = 0; l < hand_.balls.links.size(); ++l) {
    extend(static_cast<int>(l), d_H, &most, &best_H);
  }
  return X_GH_ * best_H;
}

double PosedHand::clearance(const RigidTransform& X_WG) const {
  return grasp::hand_clearance(hand_, X_WG * X_GH_, all_, scene_).clearance;
}

grasp::Advance PosedHand::advance(const RigidTransform& X_WG, const Vector3d& d_W,
                                  double most) const {
  return grasp::advance_hand(hand_, X_WG * X_GH_, all_, d_W, most, kTouching, scene_);
}

double PosedHand::meets(const geometry::TriangleMesh& mesh_W, const RigidTransform& X_WG,
                        const Vector3d& d_W, double most) const {
  const geometry::MeshQuery query(mesh_W);
  const grasp::DistanceGrid grid(query);
  const grasp::TouchScene alone{&grid, std::nullopt, nullptr};
  return grasp::advance_hand(hand_, X_WG * X_GH_, all_, d_W, most, kTouching, alone).distance;
}

}  // namespace prehend::planning
