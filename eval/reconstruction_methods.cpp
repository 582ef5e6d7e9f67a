#include "eval/reconstruction_methods.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "eval/gaussian_surface.h"
#include "eval/superquadric.h"
#include "prehend/fidelity/front.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/shape/object_view.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/mesh_parts.h"
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

Reconstruction ours_by(const fidelity::ShapeOptions& options, const SegmentedScene& scene,
                       std::size_t object) {
  const auto shapes = shape::complete_scene(scene, options.completion);
  const shape::CompletedShape& shape = shapes[object].get();
  Reconstruction result;
  result.vote = shape.symmetry.vote;
  result.evidence = shape.evidence;
  const geometry::Plane table_W = support_of(scene, scene.objects[object]);
  std::string substitute;
  try {
    result.mesh_W = surface::mesh_of(shape, table_W, options.model);
  } catch (const geometry::InputError&) {
    // Only the whole model has what stands in.
    surface::ObjectModel model = surface::make_object_model(shape, table_W, options.model);
    substitute = std::move(model.substitute);
    result.mesh_W = std::move(model.mesh_W);
  }
  result.confidence = surface::mesh_confidence(shape.confidence, substitute);
  return result;
}

Reconstruction ours(const SegmentedScene& scene, std::size_t object) {
  return ours_by({}, scene, object);
}

// As the launch files' budget:=60ms chooses.
Reconstruction fast_ours(const SegmentedScene& scene, std::size_t object) {
  static const fidelity::ShapeOptions options = fidelity::shape_options(
      fidelity::within_budget(fidelity::read_front("config/fidelity/shape.yaml"), 0.06));
  return ours_by(options, scene, object);
}

// Our points of one plane, and nothing else: whatever the plane says stays, nothing stands in.
Reconstruction mirrored_only(const SegmentedScene& scene, std::size_t object) {
  shape::CompletionOptions options;
  options.second_plane = false;
  options.drop_contradicted = false;
  options.max_contradicted = 1;
  options.min_support = 0;
  const shape::CompletedShape shape =
      shape::complete_by_symmetry(shape::view_of(scene, scene.objects[object]), options);
  surface::ModelOptions model;
  model.close_sides = false;
  model.hollow_vessels = false;
  model.keep_out_of_empty_space = false;
  model.surface.close_bottom = false;
  Reconstruction result;
  result.vote = shape.symmetry.vote;
  result.mesh_W = surface::mesh_of(shape, support_of(scene, scene.objects[object]), model);
  return result;
}

// What was seen, averaged in voxels, without outliers, with normals towards the camera.
geometry::PointCloud seen_surface(const SegmentedScene& scene, std::size_t object) {
  shape::CompletedShape seen;
  seen.cloud_W.points = scene.objects[object].cloud_W.points;
  seen.origin.assign(seen.cloud_W.size(), shape::PointOrigin::kSeen);
  seen.viewpoint_W = scene.X_WC.translation();
  return surface::oriented_cloud(seen);
}

Reconstruction gaussian_process(const SegmentedScene& scene, std::size_t object) {
  constexpr double kRoom = 0.25;  // of the longest side, for what was not seen
  const geometry::Plane table_W = support_of(scene, scene.objects[object]);
  const geometry::PointCloud seen_W = seen_surface(scene, object);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : seen_W.points) {
    box.extend(p.cast<double>());
    box.extend(table_W.project(p.cast<double>()));
  }
  const double room = kRoom * box.sizes().maxCoeff();
  const geometry::TriangleMesh surface =
      gaussian_surface(seen_W, {}, {box, box.sizes().maxCoeff()}, table_W,
                       {box.min().array() - room, box.max().array() + room});
  Reconstruction result;
  result.mesh_W = surface::solid_parts(surface, 0.05);  // as of ours
  if (result.mesh_W.empty()) {
    throw geometry::InputError("The Gaussian process has no inside", "See more of the object");
  }
  return result;
}

Reconstruction superquadric(const SegmentedScene& scene, std::size_t object) {
  const geometry::Plane table_W = support_of(scene, scene.objects[object]);
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& p : seen_surface(scene, object).points) {
    points.push_back(p.cast<double>());
    points.push_back(table_W.project(points.back()));  // as Ext knows
  }
  Reconstruction result;
  result.mesh_W = mesh_of(fit_superquadric(points), table_W);
  return result;
}

}  // namespace

std::vector<Method> known_methods() {
  const auto at_depth = [](int depth) {
    return [depth](const SegmentedScene& scene, std::size_t object) {
      return published(scene, object, depth);
    };
  };
  return {
      {"Ext", "fall-back: hull of the seen points and their feet on the table", extruded},
      {"Del", "the paper's baseline: Delaunay triangles of what was seen, contour closed",
       delaunay},
      {"Mir5", "published completion, pcl::Poisson of depth 5", at_depth(5)},
      {"Mir7", "published completion, pcl::Poisson of depth 7", at_depth(7)},
      {"Ours", "this library's defaults", ours},
      {"Fast", "this library's setting for a budget of 60 ms", fast_ours},
      {"Mirror", "mirrored points of our plane and Poisson, nothing closed or cut", mirrored_only},
      {"GPIS", "Gaussian process implicit surface of the seen points, thin-plate covariance",
       gaussian_process},
      {"Superquadric", "superquadric fitted to the seen points and their feet, cut at the table",
       superquadric},
      {"Truth", "the true mesh, for control", {}}};
}

std::vector<Method> methods_named(const std::vector<std::string>& names) {
  std::vector<Method> methods;
  const std::vector<Method> known = known_methods();
  for (const std::string& name : names) {
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const Method& method) { return method.name == name; });
    if (found == known.end()) throw std::invalid_argument("There is no method '" + name + "'");
    methods.push_back(*found);
  }
  return methods;
}

}  // namespace prehend::eval
