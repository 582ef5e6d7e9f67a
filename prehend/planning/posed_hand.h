#pragma once

#include <optional>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/planning/platform_world.h"

namespace prehend::planning {

/// A platform's hand with its joints where they are, and what it may meet on a straight way: an
/// object, the other things of a scene, and the table. Frame G of the preshape's tool. Refers to
/// `platform` and `hand`.
class PosedHand {
 public:
  /// @param motors rad or m, of the hand.
  /// @param object_W its mesh; the pieces of `scene` are of the others.
  PosedHand(const robot::Platform& platform, const grasp::HandToClose& hand,
            const robot::Preshape& preshape, const Eigen::VectorXd& motors,
            const geometry::TriangleMesh& object_W, const PlatformScene& scene);
  PosedHand(const PosedHand&) = delete;
  PosedHand& operator=(const PosedHand&) = delete;

  int fingers() const { return static_cast<int>(hand_.hand->fingers.size()); }
  bool is_of(int link, int finger) const;
  /// The point of a finger that is foremost along `d_G` (unit) [m].
  Eigen::Vector3d foremost(int finger, const Eigen::Vector3d& d_G) const;
  /// The same of the whole hand.
  Eigen::Vector3d foremost(const Eigen::Vector3d& d_G) const;

  /// Least distance from anything [m], negative inside.
  double clearance(const geometry::RigidTransform& X_WG) const;
  /// Until it meets something, at most `most` [m], along `d_W` (unit).
  grasp::Advance advance(const geometry::RigidTransform& X_WG, const Eigen::Vector3d& d_W,
                         double most) const;
  /// m, until it meets a mesh alone; `most` where it does not.
  double meets(const geometry::TriangleMesh& mesh_W, const geometry::RigidTransform& X_WG,
               const Eigen::Vector3d& d_W, double most) const;

 private:
  void extend(int link, const Eigen::Vector3d& d_H, double* most, Eigen::Vector3d* best_H) const;

  const grasp::HandToClose& hand_;
  Eigen::VectorXd all_;
  geometry::RigidTransform X_GH_;
  geometry::MeshQuery object_;
  grasp::DistanceGrid object_grid_;
  geometry::TriangleMesh obstacles_;
  std::optional<geometry::MeshQuery> obstacle_query_;
  std::optional<grasp::DistanceGrid> obstacle_grid_;
  grasp::TouchScene scene_;
  std::vector<geometry::RigidTransform> X_HL_;
};

}  // namespace prehend::planning
