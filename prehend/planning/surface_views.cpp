#include "prehend/planning/surface_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "prehend/geometry/surface_samples.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;

constexpr double kOffSurface = 5e-4;  // m, of a ray's start

// `is_seen` tells of a vertex whether it was seen.
template <class IsSeen>
std::vector<SurfacePatch> patches_of(const geometry::TriangleMesh& mesh, int count,
                                     const IsSeen& is_seen) {
  std::vector<SurfacePatch> patches;
  for (const geometry::SurfaceSample& sample : geometry::surface_samples(mesh, count, 1)) {
    const Eigen::Vector3i& corners = mesh.triangles[static_cast<std::size_t>(sample.triangle)];
    std::array<Vector3d, 3> p;
    int seen = 0;
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(corners[k]);
      p[static_cast<std::size_t>(k)] = mesh.vertices[v];
      seen += is_seen(v) ? 1 : 0;
    }
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    if (!(normal.norm() > 0)) continue;
    patches.push_back({sample.point, normal.normalized(), seen >= 2});
  }
  return patches;
}

}  // namespace

std::vector<SurfacePatch> surface_patches(const surface::ObjectModel& object, int count) {
  return patches_of(object.mesh_W, count, [&](std::size_t v) {
    // A known object has none: nothing of it is to be seen.
    return object.vertex_origin.empty() ||
           object.vertex_origin.at(v) == surface::SurfaceOrigin::kSeen;
  });
}

std::vector<SurfacePatch> surface_patches(const geometry::TriangleMesh& mesh_W, int count) {
  return patches_of(mesh_W, count, [](std::size_t) { return false; });
}

std::vector<Vector3d> even_directions(int count) {
  std::vector<Vector3d> directions;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

std::vector<char> seen_along(const std::vector<SurfacePatch>& patches, const Vector3d& direction,
                             double steepest,
                             const std::vector<const geometry::MeshQuery*>& hiding) {
  const double least = std::cos(steepest);
  std::vector<char> shown;
  for (const SurfacePatch& patch : patches) {
    const Vector3d from = patch.p_W + kOffSurface * patch.normal_W;
    shown.push_back(patch.normal_W.dot(direction) > least &&
                    std::none_of(hiding.begin(), hiding.end(), [&](const auto* mesh) {
                      return mesh->cast_ray(from, direction).has_value();
                    }));
  }
  return shown;
}

bool is_in_picture(const ViewingCamera& viewing, const Vector3d& p_W, double radius,
                   const ViewOptions& options) {
  const geometry::PinholeCamera& camera = viewing.camera;
  const Vector3d p_C = viewing.X_WC.inverse(Eigen::Isometry) * p_W;
  if (p_C.z() < options.nearest + radius) return false;
  const Eigen::Vector2d pixel = camera.project(p_C);
  const double x = camera.fx * radius / p_C.z() + options.image_margin * camera.width;
  const double y = camera.fy * radius / p_C.z() + options.image_margin * camera.height;
  return pixel.x() >= x && pixel.x() <= camera.width - 1 - x && pixel.y() >= y &&
         pixel.y() <= camera.height - 1 - y;
}

}  // namespace prehend::planning
