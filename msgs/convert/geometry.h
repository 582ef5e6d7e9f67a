#pragma once

#include <Eigen/Geometry>

#include "msgs/geometry.pb.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

/// Between protobuf messages and the library's types. `from_message` checks what it is given and
/// throws geometry::InputError for sizes that do not fit, non-unit quaternions and NaN where the
/// message may not have them; it never reads beyond a message's bytes.
namespace prehend::convert {

msgs::Vector3 to_message(const Eigen::Vector3d& v);
Eigen::Vector3d from_message(const msgs::Vector3& message);

msgs::Pose to_message(const geometry::RigidTransform& X);
/// @throws InputError for NaN and for a quaternion whose norm is not within 1e-3 of 1.
geometry::RigidTransform from_message(const msgs::Pose& message);

msgs::Plane to_message(const geometry::Plane& plane);
/// @throws InputError for NaN and for a normal whose length is not within 1e-3 of 1.
geometry::Plane from_message(const msgs::Plane& message);

/// Positions as float32, with colours and normals where the cloud has them.
msgs::PointCloud to_message(const geometry::PointCloud& cloud);
/// @throws InputError when `data` is not count * stride bytes or the stride does not fit.
geometry::PointCloud from_message(const msgs::PointCloud& message);

/// Vertices rounded to float32.
msgs::TriangleMesh to_message(const geometry::TriangleMesh& mesh);
/// @throws InputError when `data` has another size, an index is out of range or a vertex is NaN.
geometry::TriangleMesh from_message(const msgs::TriangleMesh& message);

}  // namespace prehend::convert
