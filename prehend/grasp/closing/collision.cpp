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

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/math/bv/OBB.h>
#include <fcl/narrowphase/collision.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
// Boxes alone: the spheres swept over rectangles that FCL can add serve distances, and take longest
// to make.
using Hierarchy = fcl::BVHModel<fcl::OBBd>;

// A triangle mesh as a solid obstacle.
class SolidMesh {
 public:
  explicit SolidMesh(const TriangleMesh& mesh)
      : query_(mesh), watertight_(geometry::find_defects(mesh).watertight()) {
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles) {
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    }
    hierarchy_ = std::make_shared<Hierarchy>();
    hierarchy_->beginModel(static_cast<int>(triangles.size()),
                           static_cast<int>(mesh.vertices.size()));
    hierarchy_->addSubModel(mesh.vertices, triangles);
    hierarchy_->endModel();
  }

  bool meets(const HandBox& box, const RigidTransform& X_WG, double margin) const {
    const Eigen::Vector3d size = 2 * (box.half_size.array() + margin).matrix();
    RigidTransform X_WB = X_WG;
    X_WB.translation() = X_WG * box.center_G;
    // Geometries, no CollisionObject: that would go through all vertices of the mesh each time.
    const fcl::Boxd solid_box(size);
    fcl::CollisionResultd result;
    fcl::collide(hierarchy_.get(), RigidTransform::Identity(), &solid_box, X_WB,
                 fcl::CollisionRequestd(), result);
    return result.isCollision() || (watertight_ && query_.contains(X_WB.translation()));
  }

 private:
  geometry::MeshQuery query_;
  bool watertight_;
  std::shared_ptr<Hierarchy> hierarchy_;
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
    if (!is_sound) SolidMesh{mesh};  // says at once what is wrong
  }

  bool meets(const HandBox& box, const RigidTransform& X_WG, double margin) const {
    const Eigen::Vector3d center_W = X_WG * box.center_G;
    const Eigen::Vector3d half_W =
        X_WG.linear().cwiseAbs() * (box.half_size.array() + margin).matrix();
    if (!box_W_.intersects({center_W - half_W, center_W + half_W})) return false;
    std::call_once(made_, [this] { solid_.emplace(mesh_); });
    return solid_->meets(box, X_WG, margin);
  }

 private:
  TriangleMesh mesh_;
  Eigen::AlignedBox3d box_W_;
  mutable std::once_flag made_;  // several threads ask
  mutable std::optional<SolidMesh> solid_;
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
  std::optional<SolidMesh> object;
  std::deque<Neighbour> obstacles;
  std::vector<Eigen::Vector3d> obstacle_points_W;
  geometry::Plane table;
  CollisionOptions options;
};

CollisionScene::CollisionScene(const TriangleMesh& object_W, const geometry::Plane& table,
                               const Obstacles& obstacles, const CollisionOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  options.validate();
  implementation_->table = table;
  implementation_->options = options;
  if (!object_W.empty()) implementation_->object.emplace(object_W);
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
