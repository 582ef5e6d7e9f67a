#include "prehend/simulation/surface_gap.h"

#include <algorithm>
#include <limits>

#include "prehend/simulation/rigid_body.h"

namespace prehend::simulation {
namespace {

constexpr double kSpacing = 0.004;  // m

Eigen::Vector3d normal_of(const geometry::TriangleMesh& mesh, int triangle) {
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

// Takes over what of a's points is nearer to b than `gap`. p_W is on a when `on_points`, else on b.
void shorten(const SampledSurface& a, const geometry::RigidTransform& X_WA, const SampledSurface& b,
             const geometry::RigidTransform& X_WB, bool on_points, SurfaceGap& gap) {
  const geometry::RigidTransform X_BA = X_WB.inverse(Eigen::Isometry) * X_WA;
  const Eigen::AlignedBox3d& box = b.query().box();
  for (const Eigen::Vector3d& p_A : a.points()) {
    const Eigen::Vector3d p_B = X_BA * p_A;
    if (box.exteriorDistance(p_B) >= gap.distance) continue;
    const auto nearest = b.query().nearest(p_B, gap.distance);
    if (!nearest || nearest->distance >= gap.distance) continue;
    const Eigen::Vector3d normal_W = X_WB.linear() * normal_of(b.query().mesh(), nearest->triangle);
    gap = on_points ? SurfaceGap{nearest->distance, X_WA * p_A, -normal_W}
                    : SurfaceGap{nearest->distance, X_WB * nearest->point, normal_W};
  }
}

bool has_points_in(const SampledSurface& a, const geometry::RigidTransform& X_WA,
                   const SampledSurface& b, const geometry::RigidTransform& X_WB) {
  const geometry::RigidTransform X_BA = X_WB.inverse(Eigen::Isometry) * X_WA;
  return std::any_of(a.points().begin(), a.points().end(), [&](const Eigen::Vector3d& p_A) {
    const Eigen::Vector3d p_B = X_BA * p_A;
    return b.query().box().contains(p_B) && b.query().contains(p_B);
  });
}

}  // namespace

SampledSurface::SampledSurface(const geometry::TriangleMesh& mesh_B)
    : query_(mesh_B), points_(sample_surface(mesh_B, kSpacing)) {}

double SampledSurface::lowest(const geometry::RigidTransform& X_WB) const {
  double z = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : query_.mesh().vertices) z = std::min(z, (X_WB * p).z());
  return z;
}

double SampledSurface::highest(const geometry::RigidTransform& X_WB) const {
  double z = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : query_.mesh().vertices) z = std::max(z, (X_WB * p).z());
  return z;
}

SurfaceGap surface_gap(const SampledSurface& a, const geometry::RigidTransform& X_WA,
                       const SampledSurface& b, const geometry::RigidTransform& X_WB, double most) {
  SurfaceGap gap;
  gap.distance = most;
  shorten(a, X_WA, b, X_WB, false, gap);
  shorten(b, X_WB, a, X_WA, true, gap);
  return gap;
}

bool surfaces_overlap(const SampledSurface& a, const geometry::RigidTransform& X_WA,
                      const SampledSurface& b, const geometry::RigidTransform& X_WB) {
  return has_points_in(a, X_WA, b, X_WB) || has_points_in(b, X_WB, a, X_WA);
}

}  // namespace prehend::simulation
