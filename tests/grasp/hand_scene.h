#pragma once

#include <memory>
#include <random>
#include <string>
#include <utility>

#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/closing/close_fingers.h"

namespace prehend::grasp {

/// A mesh of the world for a hand to touch.
struct TouchedMesh {
  explicit TouchedMesh(geometry::TriangleMesh mesh) : query(std::move(mesh)), grid(query) {
    scene.object_W = &grid;
  }
  TouchedMesh(const TouchedMesh&) = delete;
  geometry::MeshQuery query;
  DistanceGrid grid;
  TouchScene scene;
};

/// A hand of config/robots. Tests run in the project's folder.
struct TestHand {
  explicit TestHand(const std::string& name)
      : model(robot::read_hand_model("config/robots/" + name + ".yaml")), ready(model) {}
  TestHand(const TestHand&) = delete;
  robot::HandModel model;
  HandToClose ready;

  ClosedFingers close(const std::string& preshape, const geometry::RigidTransform& X_WH,
                      const TouchScene& scene) const {
    const robot::Preshape& shape = model.preshape(preshape);
    return close_fingers(ready, X_WH, shape, shape.open, scene);
  }
  double position(const ClosedFingers& closed, const std::string& joint) const {
    return closed.all[model.model.joint_index(joint)];
  }
};

inline geometry::TriangleMesh moved(geometry::TriangleMesh mesh,
                                    const geometry::RigidTransform& X) {
  for (auto& v : mesh.vertices) v = X * v;
  return mesh;
}
inline geometry::TriangleMesh moved(geometry::TriangleMesh mesh, const Eigen::Vector3d& by) {
  return moved(std::move(mesh), geometry::RigidTransform(Eigen::Translation3d(by)));
}

/// In (-1, 1).
inline double random_unit(std::mt19937_64& random) {
  return 2 * static_cast<double>(random() >> 11) * 0x1.0p-53 - 1;
}

inline geometry::RigidTransform random_turn(std::mt19937_64& random) {
  const Eigen::Vector4d q(random_unit(random), random_unit(random), random_unit(random),
                          random_unit(random));
  return geometry::make_transform(Eigen::Quaterniond(q.normalized()), Eigen::Vector3d::Zero());
}

/// A ring in the xy plane: `radius` [m] of its middle line, `thickness` of the tube's half.
geometry::TriangleMesh make_torus(double radius, double thickness, int around, int across);

}  // namespace prehend::grasp
