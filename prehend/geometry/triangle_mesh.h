#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::geometry {

/// An indexed triangle mesh; triangles are counter-clockwise seen from outside. Metres.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;   // v
  std::vector<Eigen::Vector3i> triangles;  // t, indices into vertices

  bool empty() const { return triangles.empty(); }
};

/// Mass properties of the solid bounded by a closed mesh.
struct MassProperties {
  double volume = 0;                                         // m^3
  Eigen::Vector3d center_of_mass = Eigen::Vector3d::Zero();  // m
  /// Inertia about the centre of mass for density 1 kg/m^3 [kg m^2 per (kg/m^3) = m^5].
  Eigen::Matrix3d unit_density_inertia = Eigen::Matrix3d::Zero();
};

/// What keeps a mesh from bounding a solid.
struct MeshDefects {
  int boundary_edges = 0;        // edges with one triangle
  int non_manifold_edges = 0;    // edges with more than two triangles
  int flipped_edges = 0;         // edges whose two triangles disagree in orientation
  int degenerate_triangles = 0;  // repeated or out-of-range indices

  bool watertight() const {
    return boundary_edges == 0 && non_manifold_edges == 0 && flipped_edges == 0 &&
           degenerate_triangles == 0;
  }
  /// "watertight" or a comma-separated list of the defects with their counts.
  std::string to_string() const;
};

/// Counts the defects of the edges of `mesh`; an empty mesh has none but is not a solid either.
MeshDefects find_defects(const TriangleMesh& mesh);

/// Volume, centre of mass and inertia by the divergence theorem (Mirtich, "Fast and Accurate
/// Computation of Polyhedral Mass Properties", 1996). Volume is negative when the mesh is inside
/// out. @pre mesh is closed for the result to mean anything.
MassProperties mass_properties(const TriangleMesh& mesh);

/// One per vertex: the mean of its triangles' normals by their areas, unit; 0 without an area.
std::vector<Eigen::Vector3d> vertex_normals(const TriangleMesh& mesh);

/// Sum of the triangles' areas [m^2].
double surface_area(const TriangleMesh& mesh);

/// Axis-aligned bounds [m]; empty box for a mesh without vertices.
Eigen::AlignedBox3d bounds(const TriangleMesh& mesh);

/// The mesh expressed in frame A, given X_AB and the mesh in frame B.
TriangleMesh transformed(const TriangleMesh& mesh_B, const RigidTransform& X_AB);

/// `mesh` with vertices closer than `tolerance` [m] merged and degenerate triangles removed.
TriangleMesh with_merged_vertices(const TriangleMesh& mesh, double tolerance);

/// All meshes as one, in order.
TriangleMesh concatenated(const std::vector<TriangleMesh>& meshes);

/// Convex hull of the vertices. @throws InputError when fewer than four points or all coplanar.
TriangleMesh convex_hull(const std::vector<Eigen::Vector3d>& points);

/// Axis-aligned box of the given full side lengths [m], centred at the origin.
TriangleMesh make_box(const Eigen::Vector3d& size);

/// Solid of revolution about z: `profile` lists (radius, z) [m] from bottom to top; the ends are
/// closed by discs (or by an apex where the radius is 0). Triangles outward for z increasing.
TriangleMesh make_revolution(const std::vector<Eigen::Vector2d>& profile, int segments = 64);

/// Sphere by latitude and longitude.
TriangleMesh make_sphere(double radius, int segments = 64);

}  // namespace prehend::geometry
