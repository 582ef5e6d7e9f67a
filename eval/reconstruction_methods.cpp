#include "eval/reconstruction_methods.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "prehend/shape/object_view.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/model.h"
#include "prehend/surface/normals.h"
#include "prehend/surface/pcl_poisson.h"

namespace prehend::eval {
namespace {

using perception::SegmentedScene;

Reconstruction extruded(const SegmentedScene& scene, std::size_t object) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& p : scene.objects[object].cloud_W.points) {
    points.push_back(p.cast<double>());
    points.push_back(scene.table_W.project(points.back()));
  }
  Reconstruction result;
  result.mesh_W = geometry::convex_hull(points);
  return result;
}

Reconstruction delaunay(const SegmentedScene& scene, std::size_t object) {
  Reconstruction result;
  result.mesh_W =
      surface::delaunay_surface(scene.objects[object].cloud_W, scene.camera, scene.X_WC);
  return result;
}

// As in section II.B of the paper: outliers go, normals of all points by the plane through the k
// nearest, those of mirrored points towards the mirrored viewpoint.
geometry::PointCloud published_cloud(const shape::CompletedShape& shape) {
  geometry::PointCloud cloud;
  std::vector<Eigen::Vector3d> viewpoints;
  for (const int i : surface::without_outliers(shape.cloud_W.points)) {
    cloud.points.push_back(shape.cloud_W.points[i]);
    viewpoints.push_back(shape.viewpoint_of(shape.origin[i]));
  }
  cloud.normals = surface::estimate_normals(cloud.points, viewpoints);
  return cloud;
}

// Whatever pcl::Poisson gives, with holes if it has any. The screening of points (Kazhdan and Hoppe
// 2013) came after the paper, so it is off.
Reconstruction published(const SegmentedScene& scene, std::size_t object, int depth) {
  const shape::CompletedShape shape = shape::complete_by_symmetry(
      shape::view_of(scene, scene.objects[object]), shape::as_published());
  surface::PclPoissonOptions options;
  options.depth = depth;
  options.point_weight = 0;
  options.samples_per_node = 1;
  Reconstruction result;
  result.vote = shape.symmetry.vote;
  result.mesh_W = surface::pcl_poisson(published_cloud(shape), options);
  return result;
}

Reconstruction ours(const SegmentedScene& scene, std::size_t object) {
  const auto shapes = shape::complete_scene(scene);
  const shape::CompletedShape& shape = shapes[object].get();
  Reconstruction result;
  result.vote = shape.symmetry.vote;
  result.evidence = shape.evidence;
  surface::ObjectModel model =
      surface::make_object_model(shape, support_of(scene, scene.objects[object]));
  result.confidence = surface::mesh_confidence(shape.confidence, model.substitute);
  result.mesh_W = std::move(model.mesh_W);
  return result;
}

}  // namespace

std::vector<Method> compared_methods() {
  const auto at_depth = [](int depth) {
    return [depth](const SegmentedScene& scene, std::size_t object) {
      return published(scene, object, depth);
    };
  };
  return {{"Ext", "fall-back: hull of the seen points and their feet on the table", extruded},
          {"Del", "the paper's baseline: Delaunay triangles of what was seen, contour closed",
           delaunay},
          {"Mir5", "published completion, pcl::Poisson of depth 5", at_depth(5)},
          {"Mir7", "published completion, pcl::Poisson of depth 7", at_depth(7)},
          {"Ours", "this library's defaults", ours}};
}

}  // namespace prehend::eval
