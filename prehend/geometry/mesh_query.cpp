#include "prehend/geometry/mesh_query.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <embree3/rtcore.h>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

// One device for the process: creating one costs milliseconds and starts threads.
RTCDevice shared_device() {
  static RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
  if (device == nullptr) throw std::runtime_error("Embree could not create a device");
  return device;
}

void check(const TriangleMesh& mesh) {
  const std::string mend = "Repair the mesh or take it from another source";
  if (mesh.empty()) throw InputError("A mesh without triangles cannot be queried", mend);
  const int vertex_count = static_cast<int>(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= vertex_count) {
      throw InputError("A mesh has a triangle with an index out of range", mend);
    }
  }
  for (const auto& v : mesh.vertices) {
    if (!v.allFinite()) throw InputError("A mesh has a vertex with NaN or infinity", mend);
  }
}

Eigen::Vector3d nearest_on_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                   const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double squared = ab.squaredNorm();
  return squared > 0 ? Eigen::Vector3d(a + std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) * ab)
                     : a;
}

// Nearest point of a triangle (Ericson, "Real-Time Collision Detection", section 5.1.5); of its
// sides where it has no area, as that divides by it.
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double longest = std::max(ab.squaredNorm(), ac.squaredNorm());
  if (!(ab.cross(ac).squaredNorm() > 1e-20 * longest * longest)) {
    const Eigen::Vector3d sides[3] = {nearest_on_segment(p, a, b), nearest_on_segment(p, b, c),
                                      nearest_on_segment(p, c, a)};
    return *std::min_element(sides, sides + 3, [&p](const auto& one, const auto& other) {
      return (one - p).squaredNorm() < (other - p).squaredNorm();
    });
  }
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
  }
  const double denominator = 1 / (va + vb + vc);
  return a + vb * denominator * ab + vc * denominator * ac;
}

// Distance and normal again in double, from the triangle itself.
RayHit exact_hit(const TriangleMesh& mesh, unsigned triangle, const Eigen::Vector3d& origin,
                 const Eigen::Vector3d& direction, float distance) {
  RayHit hit;
  hit.triangle = static_cast<int>(triangle);
  const Eigen::Vector3i& t = mesh.triangles[hit.triangle];
  const Eigen::Vector3d& a = mesh.vertices[t[0]];
  hit.normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
  const double slope = hit.normal.dot(direction);
  hit.distance = distance;
  if (std::abs(slope) > 1e-6) hit.distance = std::max(0.0, hit.normal.dot(a - origin) / slope);
  return hit;
}

struct NearestSearch {
  const TriangleMesh* mesh;
  Eigen::Vector3d point;
  NearestPoint best;
  bool found = false;
};

bool visit_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<NearestSearch*>(arguments->userPtr);
  const Eigen::Vector3i& t = search.mesh->triangles[arguments->primID];
  const auto& v = search.mesh->vertices;
  const Eigen::Vector3d q = nearest_on_triangle(search.point, v[t[0]], v[t[1]], v[t[2]]);
  const double distance = (q - search.point).norm();
  if (distance >= search.best.distance) return false;
  search.best = {q, distance, static_cast<int>(arguments->primID)};
  search.found = true;
  // A little larger than found, since the tree's boxes are rounded to single precision.
  arguments->query->radius = static_cast<float>(distance * (1 + 1e-6)) + 1e-12f;
  return true;
}

bool collect_triangle(RTCPointQueryFunctionArguments* arguments) {
  static_cast<std::vector<int>*>(arguments->userPtr)
      ->push_back(static_cast<int>(arguments->primID));
  return false;  // the radius stays
}

}  // namespace

struct MeshQuery::Implementation {
  TriangleMesh mesh;
  Eigen::AlignedBox3d box;
  RTCScene scene = nullptr;

  explicit Implementation(TriangleMesh mesh_in) : mesh(std::move(mesh_in)), box(bounds(mesh)) {
    RTCDevice device = shared_device();
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      for (int k = 0; k < 3; ++k) vertices[3 * i + k] = static_cast<float>(mesh.vertices[i][k]);
    }
    auto* indices = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) indices[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][k]);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~Implementation() { rtcReleaseScene(scene); }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
};

MeshQuery::MeshQuery(TriangleMesh mesh) {
  check(mesh);
  implementation_ = std::make_unique<Implementation>(std::move(mesh));
}
MeshQuery::~MeshQuery() = default;
MeshQuery::MeshQuery(MeshQuery&&) noexcept = default;
MeshQuery& MeshQuery::operator=(MeshQuery&&) noexcept = default;

const TriangleMesh& MeshQuery::mesh() const { return implementation_->mesh; }

std::optional<RayHit> MeshQuery::cast_ray(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction,
                                          double max_distance) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tnear = 0;
  ray.ray.tfar = static_cast<float>(max_distance);
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(implementation_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return exact_hit(implementation_->mesh, ray.hit.primID, origin, direction, ray.ray.tfar);
}

void MeshQuery::cast_rays(const std::vector<Eigen::Vector3d>& origins,
                          const Eigen::Vector3d& direction, double max_distance,
                          std::vector<std::optional<RayHit>>* hits) const {
  hits->assign(origins.size(), std::nullopt);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  constexpr std::size_t kPacket = 8;
  alignas(32) int valid[kPacket];
  RTCRayHit8 packet{};
  for (std::size_t first = 0; first < origins.size(); first += kPacket) {
    for (std::size_t k = 0; k < kPacket; ++k) {
      const bool used = first + k < origins.size();
      const Eigen::Vector3d& origin = origins[used ? first + k : first];
      valid[k] = used ? -1 : 0;
      packet.ray.org_x[k] = static_cast<float>(origin.x());
      packet.ray.org_y[k] = static_cast<float>(origin.y());
      packet.ray.org_z[k] = static_cast<float>(origin.z());
      packet.ray.dir_x[k] = static_cast<float>(direction.x());
      packet.ray.dir_y[k] = static_cast<float>(direction.y());
      packet.ray.dir_z[k] = static_cast<float>(direction.z());
      packet.ray.tnear[k] = 0;
      packet.ray.tfar[k] = static_cast<float>(max_distance);
      packet.ray.mask[k] = ~0u;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid, implementation_->scene, &context, &packet);
    for (std::size_t k = 0; k < kPacket && first + k < origins.size(); ++k) {
      if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      (*hits)[first + k] = exact_hit(implementation_->mesh, packet.hit.primID[k],
                                     origins[first + k], direction, packet.ray.tfar[k]);
    }
  }
}

const Eigen::AlignedBox3d& MeshQuery::box() const { return implementation_->box; }

std::optional<NearestPoint> MeshQuery::nearest(const Eigen::Vector3d& point,
                                               double max_distance) const {
  NearestSearch search{&implementation_->mesh, point, {}, false};
  search.best.distance = max_distance;
  RTCPointQuery query{};
  query.x = static_cast<float>(point.x());
  query.y = static_cast<float>(point.y());
  query.z = static_cast<float>(point.z());
  query.radius = static_cast<float>(std::min(max_distance, 1e18));
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(implementation_->scene, &query, &context, visit_triangle, &search);
  if (!search.found) return std::nullopt;
  return search.best;
}

void MeshQuery::near_triangles(const Eigen::Vector3d& point, double distance,
                               std::vector<int>* triangles) const {
  triangles->clear();
  RTCPointQuery query{};
  query.x = static_cast<float>(point.x());
  query.y = static_cast<float>(point.y());
  query.z = static_cast<float>(point.z());
  // A little larger, since the tree's boxes are rounded to single precision.
  const double rounded = 1e-6 * (distance + point.cwiseAbs().maxCoeff());
  query.radius = static_cast<float>(std::min(distance + rounded, 1e18));
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(implementation_->scene, &query, &context, collect_triangle, triangles);
}

bool MeshQuery::contains(const Eigen::Vector3d& point) const {
  if (!implementation_->box.contains(point)) return false;
  // Three directions without symmetry, so that edges and vertices are hit by one ray at most.
  const Eigen::Vector3d directions[3] = {Eigen::Vector3d(0.4871, 0.3127, 0.8154).normalized(),
                                         Eigen::Vector3d(-0.7213, 0.5119, 0.4663).normalized(),
                                         Eigen::Vector3d(0.1307, -0.8917, -0.4333).normalized()};
  int inside_votes = 0;
  for (const auto& direction : directions) {
    // The side on which the nearest surface is met decides: only back faces are seen from inside.
    const auto hit = cast_ray(point, direction);
    if (hit && hit->normal.dot(direction) > 0) ++inside_votes;
  }
  return inside_votes >= 2;
}

double MeshQuery::signed_distance(const Eigen::Vector3d& point) const {
  const auto found = nearest(point);
  const double distance = found ? found->distance : std::numeric_limits<double>::infinity();
  return contains(point) ? -distance : distance;
}

}  // namespace prehend::geometry
