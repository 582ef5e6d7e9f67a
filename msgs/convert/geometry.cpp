#include "msgs/convert/geometry.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

static_assert(std::endian::native == std::endian::little,
              "packed clouds and meshes are little endian and copied as they are");

using geometry::InputError;

const char* const kGeometryMend = "Mend or update the sender";

constexpr std::uint32_t kPositionBytes = 3 * sizeof(float);
constexpr std::uint32_t kColorBytes = 4;
constexpr std::uint32_t kNormalBytes = 3 * sizeof(float);

std::uint32_t point_stride(bool has_color, bool has_normal) {
  return kPositionBytes + (has_color ? kColorBytes : 0) + (has_normal ? kNormalBytes : 0);
}

void require_finite(const Eigen::Vector3d& v, const char* what) {
  if (!v.allFinite()) throw InputError(std::string(what) + " with NaN or infinity", kGeometryMend);
}

}  // namespace

msgs::Vector3 to_message(const Eigen::Vector3d& v) {
  msgs::Vector3 message;
  message.set_x(v.x());
  message.set_y(v.y());
  message.set_z(v.z());
  return message;
}

Eigen::Vector3d from_message(const msgs::Vector3& message) {
  return {message.x(), message.y(), message.z()};
}

msgs::Pose to_message(const geometry::RigidTransform& X) {
  msgs::Pose message;
  *message.mutable_position() = to_message(Eigen::Vector3d(X.translation()));
  const Eigen::Quaterniond q(X.linear());
  message.mutable_orientation()->set_w(q.w());
  message.mutable_orientation()->set_x(q.x());
  message.mutable_orientation()->set_y(q.y());
  message.mutable_orientation()->set_z(q.z());
  return message;
}

geometry::RigidTransform from_message(const msgs::Pose& message) {
  const auto& o = message.orientation();
  const Eigen::Quaterniond q(o.w(), o.x(), o.y(), o.z());
  const Eigen::Vector3d p = from_message(message.position());
  require_finite(p, "A pose's position");
  if (!(std::abs(q.norm() - 1) <= 1e-3)) {
    throw InputError(
        "A pose's orientation is not a unit quaternion (norm " + std::to_string(q.norm()) + ")",
        "Send w, x, y, z of a unit quaternion; w = 1 is no rotation");
  }
  return geometry::make_transform(q, p);
}

msgs::Plane to_message(const geometry::Plane& plane) {
  msgs::Plane message;
  *message.mutable_normal() = to_message(plane.normal);
  message.set_offset(plane.offset);
  return message;
}

geometry::Plane from_message(const msgs::Plane& message) {
  const Eigen::Vector3d normal = from_message(message.normal());
  if (!(std::abs(normal.norm() - 1) <= 1e-3) || !std::isfinite(message.offset())) {
    throw InputError("A plane without unit normal or finite offset", kGeometryMend);
  }
  return {normal.normalized(), message.offset()};
}

msgs::PointCloud to_message(const geometry::PointCloud& cloud) {
  msgs::PointCloud message;
  const std::size_t count = cloud.size();
  const bool has_color = !cloud.colors.empty();
  const bool has_normal = !cloud.normals.empty();
  const std::uint32_t stride = point_stride(has_color, has_normal);
  message.set_count(static_cast<std::uint32_t>(count));
  if (cloud.organized()) {
    message.set_width(static_cast<std::uint32_t>(cloud.width));
    message.set_height(static_cast<std::uint32_t>(cloud.height));
  }
  message.set_stride(stride);
  message.set_has_color(has_color);
  message.set_has_normal(has_normal);
  std::string& data = *message.mutable_data();
  data.resize(count * stride);
  char* out = data.data();
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(out, cloud.points[i].data(), kPositionBytes);
    out += kPositionBytes;
    if (has_color) {
      std::memcpy(out, cloud.colors[i].data(), 3);
      out[3] = 0;
      out += kColorBytes;
    }
    if (has_normal) {
      std::memcpy(out, cloud.normals[i].data(), kNormalBytes);
      out += kNormalBytes;
    }
  }
  return message;
}

geometry::PointCloud from_message(const msgs::PointCloud& message) {
  const std::uint64_t count = message.count();
  const std::uint32_t stride = point_stride(message.has_color(), message.has_normal());
  if (message.stride() != stride || message.data().size() != count * stride) {
    throw InputError("A point cloud of " + std::to_string(count) + " points of " +
                         std::to_string(message.stride()) + " bytes has " +
                         std::to_string(message.data().size()) + " bytes of data",
                     "The sender must fill count, stride and data as msgs/geometry.proto says");
  }
  const std::uint64_t grid = std::uint64_t{message.width()} * message.height();
  if (grid != 0 && grid != count) {
    throw InputError("An organized point cloud whose width times height is not its count",
                     kGeometryMend);
  }
  geometry::PointCloud cloud;
  cloud.width = static_cast<int>(message.width());
  cloud.height = static_cast<int>(message.height());
  cloud.points.resize(count);
  if (message.has_color()) cloud.colors.resize(count);
  if (message.has_normal()) cloud.normals.resize(count);
  const char* in = message.data().data();
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(cloud.points[i].data(), in, kPositionBytes);
    in += kPositionBytes;
    if (message.has_color()) {
      std::memcpy(cloud.colors[i].data(), in, 3);
      in += kColorBytes;
    }
    if (message.has_normal()) {
      std::memcpy(cloud.normals[i].data(), in, kNormalBytes);
      in += kNormalBytes;
    }
  }
  return cloud;
}

msgs::TriangleMesh to_message(const geometry::TriangleMesh& mesh) {
  msgs::TriangleMesh message;
  message.set_vertex_count(static_cast<std::uint32_t>(mesh.vertices.size()));
  message.set_triangle_count(static_cast<std::uint32_t>(mesh.triangles.size()));
  std::string& data = *message.mutable_data();
  data.resize(mesh.vertices.size() * kPositionBytes +
              mesh.triangles.size() * 3 * sizeof(std::uint32_t));
  char* out = data.data();
  for (const auto& v : mesh.vertices) {
    const Eigen::Vector3f p = v.cast<float>();
    std::memcpy(out, p.data(), kPositionBytes);
    out += kPositionBytes;
  }
  for (const auto& t : mesh.triangles) {
    std::memcpy(out, t.data(), 3 * sizeof(std::uint32_t));
    out += 3 * sizeof(std::uint32_t);
  }
  return message;
}

geometry::TriangleMesh from_message(const msgs::TriangleMesh& message) {
  const std::uint64_t vertices = message.vertex_count();
  const std::uint64_t triangles = message.triangle_count();
  if (message.data().size() != (vertices + triangles) * 12) {
    throw InputError("A mesh of " + std::to_string(vertices) + " vertices and " +
                         std::to_string(triangles) + " triangles has " +
                         std::to_string(message.data().size()) + " bytes of data",
                     "The sender must fill the counts and data as msgs/geometry.proto says");
  }
  geometry::TriangleMesh mesh;
  mesh.vertices.resize(vertices);
  mesh.triangles.resize(triangles);
  const char* in = message.data().data();
  for (auto& v : mesh.vertices) {
    Eigen::Vector3f p;
    std::memcpy(p.data(), in, kPositionBytes);
    in += kPositionBytes;
    v = p.cast<double>();
    require_finite(v, "A mesh's vertex");
  }
  for (auto& t : mesh.triangles) {
    std::uint32_t index[3];
    std::memcpy(index, in, sizeof index);
    in += sizeof index;
    for (int k = 0; k < 3; ++k) {
      if (index[k] >= vertices) throw InputError("A mesh's index out of range", kGeometryMend);
      t[k] = static_cast<int>(index[k]);
    }
  }
  return mesh;
}

}  // namespace prehend::convert
