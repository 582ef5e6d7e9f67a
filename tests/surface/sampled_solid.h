#pragma once

#include <algorithm>
#include <string>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/surface/deviation.h"

namespace prehend::surface {

/// Points on the whole of `mesh` with the normals of its triangles.
inline geometry::PointCloud sampled(const geometry::TriangleMesh& mesh, int samples) {
  const geometry::MeshQuery query(mesh);
  geometry::PointCloud cloud;
  for (const Eigen::Vector3d& p : sample_surface(mesh, samples, 3)) {
    const Eigen::Vector3i& t = mesh.triangles[query.nearest(p)->triangle];
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    const Eigen::Vector3d n = (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a);
    cloud.points.push_back(p.cast<float>());
    cloud.normals.push_back(n.normalized().cast<float>());
  }
  return cloud;
}

/// Everything of `mesh` moved by `shift` [m].
inline geometry::TriangleMesh shifted(const geometry::TriangleMesh& mesh,
                                      const Eigen::Vector3d& shift) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = shift;
  return geometry::transformed(mesh, X);
}

/// A ring of square cross-section: outer and inner radius, height [m].
inline geometry::TriangleMesh make_ring(double outer, double inner, double height,
                                        int segments = 48) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / segments;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    for (const auto& [r, z] :
         {std::pair{outer, 0.0}, {outer, height}, {inner, height}, {inner, 0.0}}) {
      mesh.vertices.push_back(r * out + z * Eigen::Vector3d::UnitZ());
    }
  }
  for (int i = 0; i < segments; ++i) {
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * i + k;
      const int b = 4 * i + (k + 1) % 4;
      const int c = 4 * ((i + 1) % segments) + k;
      const int d = 4 * ((i + 1) % segments) + (k + 1) % 4;
      mesh.triangles.emplace_back(a, c, d);
      mesh.triangles.emplace_back(a, d, b);
    }
  }
  return mesh;
}

/// A torus about z of 2 * around * across triangles; radii of its circle and of its tube [m].
inline geometry::TriangleMesh make_torus(double major, double minor, int around, int across) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * EIGEN_PI * i / around;
      const double v = 2 * EIGEN_PI * j / across;
      const double r = major + minor * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
      const int a = i * across + j;
      const int b = i * across + (j + 1) % across;
      const int c = (i + 1) % around * across + j;
      const int d = (i + 1) % around * across + (j + 1) % across;
      mesh.triangles.emplace_back(a, c, d);
      mesh.triangles.emplace_back(a, d, b);
    }
  }
  return mesh;
}

/// An L: the unit profile (0,0) (2,0) (2,1) (1,1) (1,2) (0,2) times `side` [m], extruded by `side`.
inline geometry::TriangleMesh make_l_shape(double side) {
  const std::vector<Eigen::Vector2d> profile{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  geometry::TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (const Eigen::Vector2d& p : profile)
      mesh.vertices.emplace_back(side * Eigen::Vector3d(p.x(), p.y(), z));
  }
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.emplace_back(i, j, 6 + j);
    mesh.triangles.emplace_back(i, 6 + j, 6 + i);
  }
  for (const Eigen::Vector3i& t : {Eigen::Vector3i(0, 1, 2), {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.emplace_back(t.x() + 6, t.y() + 6, t.z() + 6);
    mesh.triangles.emplace_back(t.x(), t.z(), t.y());
  }
  return mesh;
}

/// `mesh` with every triangle cut into four, `times` times over; vertices are shared.
inline geometry::TriangleMesh subdivided(geometry::TriangleMesh mesh, int times) {
  for (; times > 0; --times) {
    geometry::TriangleMesh finer;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices[t.x()];
      const Eigen::Vector3d b = mesh.vertices[t.y()];
      const Eigen::Vector3d c = mesh.vertices[t.z()];
      const int first = static_cast<int>(finer.vertices.size());
      for (const Eigen::Vector3d& p :
           {a, b, c, Eigen::Vector3d((a + b) / 2), Eigen::Vector3d((b + c) / 2),
            Eigen::Vector3d((c + a) / 2)}) {
        finer.vertices.push_back(p);
      }
      for (const Eigen::Vector3i& q : {Eigen::Vector3i(0, 3, 5), {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}) {
        finer.triangles.push_back(q + Eigen::Vector3i::Constant(first));
      }
    }
    mesh = geometry::with_merged_vertices(finer, 1e-7);
  }
  return mesh;
}

}  // namespace prehend::surface
