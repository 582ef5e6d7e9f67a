#include "eval/reconstruction_methods.h"

#include <vector>

#include <pcl/point_types.h>
#include <pcl/surface/poisson.h>

#include "prehend/shape/symmetry.h"
#include "prehend/surface/model.h"
#include "prehend/surface/normals.h"

namespace prehend::eval {
namespace {

using perception::ObjectHypothesis;
using perception::SegmentedScene;

shape::CompletedShape completed(const SegmentedScene& scene, const ObjectHypothesis& object,
                                const shape::CompletionOptions& options) {
  return shape::complete_by_symmetry(
      {object.cloud_W, object.mask, scene.camera, scene.X_WC, scene.table_W}, options);
}

Reconstruction extruded(const SegmentedScene& scene, const ObjectHypothesis& object) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& p : object.cloud_W.points) {
    points.push_back(p.cast<double>());
    points.push_back(scene.table_W.project(points.back()));
  }
  Reconstruction result;
  result.mesh_W = geometry::convex_hull(points);
  return result;
}

// As the paper used it: whatever pcl::Poisson gives, with holes if it has any.
geometry::TriangleMesh plain_poisson(const geometry::PointCloud& cloud, int depth) {
  const auto points = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f &p = cloud.points[i], &n = cloud.normals[i];
    points->emplace_back(p.x(), p.y(), p.z(), n.x(), n.y(), n.z());
  }
  pcl::Poisson<pcl::PointNormal> poisson;
  poisson.setDepth(depth);
  poisson.setThreads(1);
  poisson.setInputCloud(points);
  pcl::PointCloud<pcl::PointNormal> vertices;
  std::vector<pcl::Vertices> polygons;
  poisson.reconstruct(vertices, polygons);
  geometry::TriangleMesh mesh;
  for (const pcl::PointNormal& v : vertices) mesh.vertices.emplace_back(v.x, v.y, v.z);
  for (const pcl::Vertices& polygon : polygons) {
    const auto& v = polygon.vertices;
    for (std::size_t k = 2; k < v.size(); ++k) {
      mesh.triangles.emplace_back(static_cast<int>(v[0]), static_cast<int>(v[k - 1]),
                                  static_cast<int>(v[k]));
    }
  }
  return mesh;
}

Reconstruction published(const SegmentedScene& scene, const ObjectHypothesis& object, int depth) {
  const shape::CompletedShape shape = completed(scene, object, shape::as_published());
  Reconstruction result;
  result.vote = shape.symmetry.vote;
  result.mesh_W = plain_poisson(surface::oriented_cloud(shape), depth);
  return result;
}

Reconstruction ours(const SegmentedScene& scene, const ObjectHypothesis& object) {
  const shape::CompletedShape shape = completed(scene, object, {});
  Reconstruction result;
  result.vote = shape.symmetry.vote;
  result.mesh_W = surface::make_object_model(shape, scene.table_W).mesh_W;
  return result;
}

}  // namespace

std::vector<Method> compared_methods() {
  const auto at_depth = [](int depth) {
    return [depth](const SegmentedScene& scene, const ObjectHypothesis& object) {
      return published(scene, object, depth);
    };
  };
  return {{"Ext", "fall-back: hull of the seen points and their feet on the table", extruded},
          {"Mir5", "published completion, pcl::Poisson of depth 5", at_depth(5)},
          {"Mir7", "published completion, pcl::Poisson of depth 7", at_depth(7)},
          {"Ours", "this library's defaults", ours}};
}

}  // namespace prehend::eval
