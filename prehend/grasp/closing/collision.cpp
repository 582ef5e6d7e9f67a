#include "prehend/grasp/closing/collision.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "prehend/geometry/box_query.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using geometry::SurfaceQuery;
using geometry::TriangleMesh;

// A surface as an obstacle; a solid one where it is watertight.
class SolidSurface {
 public:
  explicit SolidSurface(const SurfaceQuery& surface_W) : surface_W_(surface_W) {}

  bool meets(const HandBox& box, const RigidTransform& X_WG, double margin) const {
    RigidTransform X_WB = X_WG;
    X_WB.translation() = X_WG * box.center_G;
    if (geometry::does_surface_meet_box(surface_W_, X_WB, box.half_size.array() + margin)) {
      return true;
    }
    return surface_W_.contains(X_WB.translation()) && is_watertight();
  }

 private:
  bool is_watertight() const {
    std::call_once(looked_at_, [this] {
      watertight_ = geometry::find_defects(surface_W_.mesh()).watertight();
    });
    return watertight_;
  }

  const SurfaceQuery& surface_W_;
  mutable std::once_flag looked_at_;  // several threads ask
  mutable bool watertight_ = false;
};

// A mesh that is made ready when a hand first comes near: neighbours out of reach never are.
class Neighbour {
 public:
  explicit Neighbour(const TriangleMesh& mesh) : mesh_(mesh) {
    const int vertices = static_cast<int>(mesh.vertices.size());
    bool is_sound = true;
    for (const auto& v : mesh.vertices) {
      is_sound = is_sound && v.allFinite();
      box_W_.extend(v);
    }
    for (const auto& t : mesh.triangles) {
      is_sound = is_sound && t.minCoeff() >= 0 && t.maxCoeff() < vertices;
    }
    if (!is_sound) geometry::MeshQuery{mesh};  // says at once what is wrong
  }

  bool meets(const HandBox& box, const RigidTransform& X_WG, double margin) const {
    const Eigen::Vector3d center_W = X_WG * box.center_G;
    const Eigen::Vector3d half_W =
        X_WG.linear().cwiseAbs() * (box.half_size.array() + margin).matrix();
    if (!box_W_.intersects({center_W - half_W, center_W + half_W})) return false;
    std::call_once(made_, [this] { solid_.emplace(query_W_.emplace(mesh_)); });
    return solid_->meets(box, X_WG, margin);
  }

 private:
  TriangleMesh mesh_;
  Eigen::AlignedBox3d box_W_;
  mutable std::once_flag made_;  // several threads ask
  mutable std::optional<geometry::MeshQuery> query_W_;
  mutable std::optional<SolidSurface> solid_;
};

bool meets_any_point(const std::vector<Eigen::Vector3d>& points_W, const HandBox& box,
                     const RigidTransform& X_WG, double margin) {
  const RigidTransform X_GW = X_WG.inverse();
  const Eigen::Array3d limit = box.half_size.array() + margin;
  return std::any_of(points_W.begin(), points_W.end(), [&](const Eigen::Vector3d& p_W) {
    return ((X_GW * p_W - box.center_G).array().abs() <= limit).all();
  });
}

}  // namespace

void CollisionOptions::validate() const {
  const text::Require require{"CollisionOptions."};
  require(table_margin >= 0, "table_margin must not be negative");
  require(object_margin >= 0, "object_margin must not be negative");
  require(obstacle_margin >= 0, "obstacle_margin must not be negative");
}

std::vector<HandBox> swept_hand(const robot::GripperModel& gripper, double opening,
                                double approach_distance) {
  const auto box = [approach_distance](double y, const Eigen::Vector3d& size, double front_z) {
    const double length = size.z() + approach_distance;
    return HandBox{{0, y, front_z - length / 2}, {size.x() / 2, size.y() / 2, length / 2}};
  };
  const double finger_y = opening / 2 + gripper.finger_size.y() / 2;
  return {box(finger_y, gripper.finger_size, gripper.tip_z()),
          box(-finger_y, gripper.finger_size, gripper.tip_z()),
          box(0, gripper.housing_size, gripper.housing_front_z())};
}

struct CollisionScene::Implementation {
  std::optional<SolidSurface> object;
  std::deque<Neighbour> obstacles;
  std::vector<Eigen::Vector3d> obstacle_points_W;
  geometry::Plane table;
  CollisionOptions options;
};

CollisionScene::CollisionScene(const SurfaceQuery* object_W, const geometry::Plane& table,
                               const Obstacles& obstacles, const CollisionOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  options.validate();
  implementation_->table = table;
  implementation_->options = options;
  if (object_W != nullptr) implementation_->object.emplace(*object_W);
  for (const auto& mesh_W : obstacles.meshes_W) {
    if (!mesh_W.empty()) implementation_->obstacles.emplace_back(mesh_W);
  }
  for (const auto& p : obstacles.cloud_W.points) {
    if (p.allFinite()) implementation_->obstacle_points_W.push_back(p.cast<double>());
  }
}

CollisionScene::~CollisionScene() = default;
CollisionScene::CollisionScene(CollisionScene&&) noexcept = default;
CollisionScene& CollisionScene::operator=(CollisionScene&&) noexcept = default;

double CollisionScene::table_clearance(const std::vector<HandBox>& hand,
                                       const RigidTransform& X_WG) const {
  // The lowest corner: centre height minus the half sizes projected on the normal.
  const auto& table = implementation_->table;
  const Eigen::Vector3d normal_G = X_WG.linear().transpose() * table.normal;
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& box : hand) {
    lowest = std::min(lowest, table.signed_distance(X_WG * box.center_G) -
                                  normal_G.cwiseAbs().dot(box.half_size));
  }
  return lowest;
}

bool CollisionScene::touches_object(const std::vector<HandBox>& hand,
                                    const RigidTransform& X_WG) const {
  const double margin = implementation_->options.object_margin;
  return implementation_->object && std::any_of(hand.begin(), hand.end(), [&](const HandBox& box) {
           return implementation_->object->meets(box, X_WG, margin);
         });
}

HandCollision CollisionScene::check(const std::vector<HandBox>& hand,
                                    const RigidTransform& X_WG) const {
  const auto& options = implementation_->options;
  if (table_clearance(hand, X_WG) < options.table_margin) return HandCollision::kTable;
  if (touches_object(hand, X_WG)) return HandCollision::kObject;
  for (const auto& box : hand) {
    for (const auto& obstacle : implementation_->obstacles) {
      if (obstacle.meets(box, X_WG, options.obstacle_margin)) return HandCollision::kObstacle;
    }
    if (meets_any_point(implementation_->obstacle_points_W, box, X_WG, options.obstacle_margin)) {
      return HandCollision::kObstacle;
    }
  }
  return HandCollision::kNone;
}

}  // namespace prehend::grasp
