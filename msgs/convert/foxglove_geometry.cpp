#include "msgs/convert/foxglove_geometry.h"

#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {

google::protobuf::Timestamp foxglove_time(std::int64_t stamp) {
  google::protobuf::Timestamp time;
  if (stamp <= 0) return time;
  time.set_seconds(stamp / 1'000'000'000);
  time.set_nanos(static_cast<std::int32_t>(stamp % 1'000'000'000));
  return time;
}

::foxglove::Vector3 foxglove_vector(const Eigen::Vector3d& v) {
  ::foxglove::Vector3 result;
  result.set_x(v.x());
  result.set_y(v.y());
  result.set_z(v.z());
  return result;
}

::foxglove::Point3 foxglove_point(const Eigen::Vector3d& p) {
  ::foxglove::Point3 result;
  result.set_x(p.x());
  result.set_y(p.y());
  result.set_z(p.z());
  return result;
}

::foxglove::Pose foxglove_pose(const geometry::RigidTransform& X) {
  const Eigen::Quaterniond q(X.linear());
  ::foxglove::Pose pose;
  *pose.mutable_position() = foxglove_vector(X.translation());
  pose.mutable_orientation()->set_x(q.x());
  pose.mutable_orientation()->set_y(q.y());
  pose.mutable_orientation()->set_z(q.z());
  pose.mutable_orientation()->set_w(q.w());
  return pose;
}

::foxglove::Pose foxglove_pose_along(const Eigen::Vector3d& origin,
                                     const Eigen::Vector3d& direction) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), direction).toRotationMatrix();
  X.translation() = origin;
  return foxglove_pose(X);
}

::foxglove::Color foxglove_color(double r, double g, double b, double a) {
  ::foxglove::Color color;
  color.set_r(r);
  color.set_g(g);
  color.set_b(b);
  color.set_a(a);
  return color;
}

::foxglove::TriangleListPrimitive foxglove_triangles(const geometry::TriangleMesh& mesh) {
  ::foxglove::TriangleListPrimitive triangles;
  *triangles.mutable_pose() = foxglove_pose(geometry::RigidTransform::Identity());
  triangles.mutable_points()->Reserve(static_cast<int>(mesh.vertices.size()));
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    *triangles.add_points() = foxglove_point(vertex);
  }
  triangles.mutable_indices()->Reserve(3 * static_cast<int>(mesh.triangles.size()));
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) triangles.add_indices(static_cast<std::uint32_t>(triangle[k]));
  }
  return triangles;
}

::foxglove::TriangleListPrimitive foxglove_triangles(const msgs::TriangleMesh& mesh) {
  const std::uint64_t vertices = mesh.vertex_count(), triangles = mesh.triangle_count();
  if (mesh.data().size() != 12 * (vertices + triangles)) {
    throw geometry::InputError("A mesh's data has another size than its counts say", kSenderMend);
  }
  ::foxglove::TriangleListPrimitive result;
  *result.mutable_pose() = foxglove_pose(geometry::RigidTransform::Identity());
  result.mutable_points()->Reserve(static_cast<int>(vertices));
  const char* at = mesh.data().data();
  for (std::uint64_t i = 0; i < vertices; ++i, at += 12) {
    float xyz[3];
    std::memcpy(xyz, at, sizeof xyz);
    *result.add_points() = foxglove_point({xyz[0], xyz[1], xyz[2]});
  }
  result.mutable_indices()->Resize(static_cast<int>(3 * triangles), 0);
  if (triangles > 0) {
    std::memcpy(result.mutable_indices()->mutable_data(), at, 12 * triangles);
  }
  for (const std::uint32_t index : result.indices()) {
    if (index >= vertices) {
      throw geometry::InputError("A mesh's triangle has a vertex that is not there", kSenderMend);
    }
  }
  return result;
}

::foxglove::SceneEntity foxglove_entity(const std::string& id, const std::string& frame,
                                        std::int64_t stamp, bool frame_locked) {
  ::foxglove::SceneEntity entity;
  *entity.mutable_timestamp() = foxglove_time(stamp);
  entity.set_frame_id(frame);
  entity.set_id(id);
  entity.set_frame_locked(frame_locked);
  entity.mutable_lifetime();
  return entity;
}

void add_metadata(::foxglove::SceneEntity& entity, const std::string& key,
                  const std::string& value) {
  ::foxglove::KeyValuePair& pair = *entity.add_metadata();
  pair.set_key(key);
  pair.set_value(value);
}

void add_metadata(::foxglove::SceneEntity& entity, const std::string& key, double value) {
  add_metadata(entity, key, fmt::format("{:.6g}", value));
}

void add_deletion(::foxglove::SceneUpdate& update, const std::string& id, std::int64_t stamp) {
  ::foxglove::SceneEntityDeletion& deletion = *update.add_deletions();
  *deletion.mutable_timestamp() = foxglove_time(stamp);
  deletion.set_type(::foxglove::SceneEntityDeletion::MATCHING_ID);
  deletion.set_id(id);
}

}  // namespace prehend::convert
