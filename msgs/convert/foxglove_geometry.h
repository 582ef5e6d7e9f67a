#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include "foxglove/Color.pb.h"
#include "foxglove/Point3.pb.h"
#include "foxglove/Pose.pb.h"
#include "foxglove/SceneEntity.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "foxglove/TriangleListPrimitive.pb.h"
#include "foxglove/Vector3.pb.h"
#include "msgs/geometry.pb.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

// Of our types as the well-known ones that viewers draw (msgs/foxglove). Metres, radians; the frame
// of the world is called kWorldFrame.
namespace prehend::convert {

inline constexpr const char* kWorldFrame = "world";

/// [ns] since the clock's zero; what is before it is 0.
google::protobuf::Timestamp foxglove_time(std::int64_t stamp);
::foxglove::Vector3 foxglove_vector(const Eigen::Vector3d& v);
::foxglove::Point3 foxglove_point(const Eigen::Vector3d& p);
::foxglove::Pose foxglove_pose(const geometry::RigidTransform& X);
/// Whose x points along `direction` (not 0), as arrows do.
::foxglove::Pose foxglove_pose_along(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction);
::foxglove::Color foxglove_color(double r, double g, double b, double a = 1);

/// Indexed, without a colour.
::foxglove::TriangleListPrimitive foxglove_triangles(const geometry::TriangleMesh& mesh);
/// The same without the way over the library's mesh. @throws geometry::InputError when `data` has
/// another size or an index is out of range.
::foxglove::TriangleListPrimitive foxglove_triangles(const msgs::TriangleMesh& mesh);

/// An entity without any primitive.
::foxglove::SceneEntity foxglove_entity(const std::string& id, const std::string& frame,
                                        std::int64_t stamp, bool frame_locked);
void add_metadata(::foxglove::SceneEntity& entity, const std::string& key,
                  const std::string& value);
/// A number as %g has it.
void add_metadata(::foxglove::SceneEntity& entity, const std::string& key, double value);
/// Deletes what was there of this id, whenever it came.
void add_deletion(::foxglove::SceneUpdate& update, const std::string& id, std::int64_t stamp);

}  // namespace prehend::convert
