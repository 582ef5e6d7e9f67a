#include "prehend/contact/mesh_rays.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <embree3/rtcore.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

namespace prehend::contact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Embree reports a hit up to this much beyond the limit or before the ray's start, by its single
// precision; what the double-precision distance says counts [relative to the coordinates].
constexpr double kSinglePrecision = 1e-5;

}  // namespace

struct MeshRays::Implementation {
  geometry::TriangleMesh mesh;
  double extent = 0;  // m, largest coordinate
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~Implementation() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  // n (p - a) = 0 of each triangle; n is not unit.
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> offsets;
};

MeshRays::MeshRays(geometry::TriangleMesh mesh)
    : implementation_(std::make_unique<Implementation>()) {
  if (mesh.empty()) {
    throw geometry::InputError("the mesh for contact has no triangles", "Give a closed mesh");
  }
  for (const Eigen::Vector3d& v : mesh.vertices) {
    if (!v.allFinite()) {
      throw geometry::InputError("the mesh for contact has a vertex that is not finite",
                                 "Remove it");
    }
    implementation_->extent = std::max(implementation_->extent, v.cwiseAbs().maxCoeff());
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= count) {
      throw geometry::InputError(
          "the mesh for contact has a triangle of a vertex that is not there",
          "Correct its indices");
    }
  }
  implementation_->mesh = std::move(mesh);
  const geometry::TriangleMesh& m = implementation_->mesh;
  implementation_->device = rtcNewDevice("threads=1");
  if (!implementation_->device) {
    throw geometry::InputError("Embree has no device for this processor", "Use a newer processor");
  }
  implementation_->scene = rtcNewScene(implementation_->device);
  rtcSetSceneFlags(implementation_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(implementation_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               m.vertices.size()));
  for (const Eigen::Vector3d& v : m.vertices) {
    for (int k = 0; k < 3; ++k) *vertices++ = static_cast<float>(v[k]);
  }
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), m.triangles.size()));
  for (const Eigen::Vector3i& t : m.triangles) {
    const Eigen::Vector3d &a = m.vertices[t[0]], &b = m.vertices[t[1]], &c = m.vertices[t[2]];
    implementation_->normals.push_back((b - a).cross(c - a));
    implementation_->offsets.push_back(implementation_->normals.back().dot(a));
    for (int k = 0; k < 3; ++k) *indices++ = static_cast<unsigned>(t[k]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(implementation_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(implementation_->scene);
}

MeshRays::~MeshRays() = default;

double MeshRays::plane_distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                int triangle, double limit) const {
  const Eigen::Vector3d& normal = implementation_->normals[triangle];
  const double facing = normal.dot(direction);
  if (facing >= 0) return 0;
  const double result = (implementation_->offsets[triangle] - normal.dot(origin)) / facing;
  if (result > limit) return kInfinity;
  return std::max(0.0, result);
}

const geometry::TriangleMesh& MeshRays::mesh() const { return implementation_->mesh; }

double MeshRays::first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                           double limit) const {
  Packet packet;
  for (int i = 0; i < kPacket; ++i) {
    packet.ox[i] = origin.x();
    packet.oy[i] = origin.y();
    packet.oz[i] = origin.z();
    packet.dx[i] = direction.x();
    packet.dy[i] = direction.y();
    packet.dz[i] = direction.z();
    packet.active[i] = i == 0;
  }
  first_hits(packet, limit);
  return packet.distance[0];
}

void MeshRays::first_hits(Packet& packet, double limit) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(32) int valid[kPacket];
  RTCRayHit8 rays;
  // To the mesh's far side, so that a ray that begins inside sees the back of what it leaves by.
  const auto far = static_cast<float>(4 * implementation_->extent + limit);
  for (int i = 0; i < kPacket; ++i) {
    valid[i] = packet.active[i] ? -1 : 0;
    rays.ray.org_x[i] = static_cast<float>(packet.ox[i]);
    rays.ray.org_y[i] = static_cast<float>(packet.oy[i]);
    rays.ray.org_z[i] = static_cast<float>(packet.oz[i]);
    rays.ray.dir_x[i] = static_cast<float>(packet.dx[i]);
    rays.ray.dir_y[i] = static_cast<float>(packet.dy[i]);
    rays.ray.dir_z[i] = static_cast<float>(packet.dz[i]);
    rays.ray.tnear[i] = 0;
    rays.ray.tfar[i] = far;
    rays.ray.time[i] = 0;
    rays.ray.mask[i] = ~0u;
    rays.ray.id[i] = 0;
    rays.ray.flags[i] = 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  rtcIntersect8(valid, implementation_->scene, &context, &rays);
  for (int i = 0; i < kPacket; ++i) {
    packet.distance[i] = kInfinity;
    packet.triangle[i] = kNone;
    if (!packet.active[i] || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const double seen = rays.ray.tfar[i];
    const int triangle = static_cast<int>(rays.hit.primID[i]);
    const double distance =
        plane_distance({packet.ox[i], packet.oy[i], packet.oz[i]},
                       {packet.dx[i], packet.dy[i], packet.dz[i]}, triangle, limit);
    packet.distance[i] = distance;
    if (distance < kInfinity) packet.triangle[i] = triangle;
    // Seen edge-on, a plane says nothing; then the single-precision distance is the better one.
    if (std::abs(distance - seen) > kSinglePrecision * (1 + implementation_->extent) &&
        distance != 0 && distance != kInfinity) {
      packet.distance[i] = seen <= limit ? seen : kInfinity;
      packet.triangle[i] = kEdgeOn;
    }
  }
}

}  // namespace prehend::contact
