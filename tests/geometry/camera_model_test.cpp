#include "prehend/geometry/camera_model.h"

#include <gtest/gtest.h>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::geometry {
namespace {

TEST(PinholeCamera, ProjectsAndUnprojectsToTheSamePoint) {
  const PinholeCamera camera{640, 480, 525, 530, 319.5, 239.5};
  const Eigen::Vector3d p_C(0.1, -0.2, 1.7);
  const Eigen::Vector2d pixel = camera.project(p_C);
  EXPECT_NEAR(pixel.x(), 525 * 0.1 / 1.7 + 319.5, 1e-12);
  EXPECT_TRUE(camera.unproject(pixel.x(), pixel.y(), 1.7).isApprox(p_C, 1e-12));
}

TEST(LookAt, PutsTheTargetOnTheOpticalAxisWithTheImageUpright) {
  const Eigen::Vector3d eye(0.5, -0.4, 0.6), target(0.1, 0.2, 0.05);
  const RigidTransform X_WC = look_at(eye, target);
  const Eigen::Vector3d target_C = X_WC.inverse() * target;
  EXPECT_NEAR(target_C.head<2>().norm(), 0, 1e-12);
  EXPECT_NEAR(target_C.z(), (target - eye).norm(), 1e-12);
  EXPECT_LT((X_WC.linear().transpose() * Eigen::Vector3d::UnitZ()).y(), 0);  // up is -y
  EXPECT_NEAR(X_WC.linear().determinant(), 1, 1e-12);
}

TEST(Plane, MeasuresHeightAndProjects) {
  const Plane plane{Eigen::Vector3d(0, 0.6, 0.8), 0.5};
  const Eigen::Vector3d p(1, 2, 3);
  EXPECT_NEAR(plane.signed_distance(p), 0.6 * 2 + 0.8 * 3 - 0.5, 1e-12);
  EXPECT_NEAR(plane.signed_distance(plane.project(p)), 0, 1e-12);
}

}  // namespace
}  // namespace prehend::geometry
