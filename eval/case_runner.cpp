#include "eval/case_runner.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include "eval/household_objects.h"
#include "eval/processor_time.h"
#include "eval/resting_pose.h"
#include "eval/solid_overlap.h"
#include "eval/structured_light.h"
#include "prehend/perception/binning.h"
#include "prehend/perception/stereo.h"
#include "prehend/surface/deviation.h"

namespace prehend::eval {
namespace {

constexpr int kSamples = 10000;        // on each surface
constexpr double kLeastOverlap = 0.2;  // of mask and truth, for the object to count as found

// Mean of the area, defined for open surfaces, too.
Eigen::Vector3d area_centroid(const geometry::TriangleMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[t.x()], &b = mesh.vertices[t.y()],
                          &c = mesh.vertices[t.z()];
    const double area = (b - a).cross(c - a).norm();
    sum += area * (a + b + c) / 3;
    total += area;
  }
  return sum / total;
}

// Binned by the options.
geometry::DepthImage depth_by(const RenderedScene& rendered, const simulation::StereoImages& images,
                              const fidelity::SeeingOptions& options) {
  const geometry::StereoCamera& camera = rendered.scene.camera.camera;
  if (rendered.sensor == DepthSensor::kStructuredLight) {
    return perception::binned(
        structured_light(images.depth, images.labels, camera.left,
                         {.missing = rendered.missing, .seed = rendered.scene.camera.seed}),
        options.binning);
  }
  const geometry::StereoCamera binned = perception::binned(camera, options.binning);
  return perception::depth_from_disparity(
      perception::stereo_disparity(perception::binned(images.left, options.binning),
                                   perception::binned(images.right, options.binning), binned,
                                   options.stereo),
      binned);
}

// One label of the pixels that a mask's pixel covers.
geometry::Image<std::int16_t> labels_at(const geometry::MaskImage& mask,
                                        const geometry::Image<std::int16_t>& labels) {
  if (mask.width == labels.width) return labels;
  const int n = labels.width / std::max(mask.width, 1);
  geometry::Image<std::int16_t> own(mask.width, mask.height);
  for (int v = 0; v < own.height; ++v) {
    for (int u = 0; u < own.width; ++u) own.at(u, v) = labels.at(n * u + n / 2, n * v + n / 2);
  }
  return own;
}

// What the method makes, and the processor's seconds it took: the faster of two times, since the
// first one of a process also loads what it needs.
std::pair<Reconstruction, double> timed_reconstruction(const Method& method,
                                                       const perception::SegmentedScene& scene,
                                                       std::size_t object,
                                                       const geometry::TriangleMesh& truth_W) {
  Reconstruction made;
  if (!method.reconstruct) {
    made.mesh_W = truth_W;
    return {std::move(made), kUnknown};
  }
  double spent = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 2; ++i) {
    const double start = processor_time();
    made = method.reconstruct(scene, object);
    spent = std::min(spent, processor_time() - start);
  }
  return {std::move(made), spent};
}

}  // namespace

double mask_iou(const geometry::MaskImage& mask, const geometry::Image<std::int16_t>& labels,
                std::int16_t label) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const bool a = mask.data[i] != 0, b = labels.data[i] == label;
    both += a && b;
    either += a || b;
  }
  return either > 0 ? both / either : 0;
}

std::optional<std::size_t> object_of(const perception::SegmentedScene& scene,
                                     const geometry::Image<std::int16_t>& labels) {
  std::optional<std::size_t> best;
  double most = kLeastOverlap;
  for (std::size_t k = 0; k < scene.objects.size(); ++k) {
    const geometry::MaskImage& mask = scene.objects[k].mask;
    const double overlap = mask_iou(mask, labels_at(mask, labels), 0);
    if (overlap <= most) continue;
    most = overlap;
    best = k;
  }
  return best;
}

MethodResult measured(const geometry::TriangleMesh& mesh_B, const geometry::TriangleMesh& truth_B,
                      std::uint64_t seed) {
  const auto [there, back] = surface::mesh_deviation(truth_B, mesh_B, {kSamples, seed});
  MethodResult result;
  result.mean = there.mean;
  result.percentile_95 = there.percentile_95;
  result.max = there.max;
  result.back_mean = back.mean;
  result.back_max = back.max;
  result.variance = there.variance;
  result.centroid_error = (area_centroid(mesh_B) - area_centroid(truth_B)).norm() /
                          geometry::bounds(truth_B).sizes().norm();
  result.normal_error = surface::median_normal_error(mesh_B, truth_B, {kSamples, seed});
  result.watertight = geometry::find_defects(mesh_B).watertight();
  return result;
}

geometry::DepthImage seen_depth(const RenderedScene& rendered,
                                const simulation::StereoImages& images) {
  return depth_by(rendered, images, {});
}

perception::SegmentedScene seen_scene(const RenderedScene& rendered,
                                      const simulation::StereoImages& images,
                                      const geometry::DepthImage& depth,
                                      const perception::SegmentationOptions& options) {
  fidelity::SeeingOptions seeing;
  seeing.segmentation = options;
  return seen_scene(
      rendered, perception::cloud_from_depth(depth, rendered.scene.camera.camera.left, images.left),
      seeing);
}

perception::SegmentedScene seen_scene(const RenderedScene& rendered,
                                      const geometry::PointCloud& cloud_C,
                                      const fidelity::SeeingOptions& options) {
  const int n = perception::binning_to(cloud_C, options.points);
  return perception::segment(perception::binned(cloud_C, n),
                             perception::binned(rendered.scene.camera.camera.left, n),
                             rendered.scene.camera.X_WC(), options.segmentation, options.table);
}

geometry::PointCloud seen_cloud(const RenderedScene& rendered,
                                const simulation::StereoImages& images) {
  return perception::cloud_from_depth(seen_depth(rendered, images),
                                      rendered.scene.camera.camera.left, images.left);
}

perception::SegmentedScene seen_scene(const RenderedScene& rendered,
                                      const simulation::StereoImages& images,
                                      const fidelity::SeeingOptions& options) {
  const geometry::PinholeCamera camera =
      perception::binned(rendered.scene.camera.camera.left, options.binning);
  const geometry::PointCloud cloud_C =
      perception::cloud_from_depth(depth_by(rendered, images, options), camera,
                                   perception::binned(images.left, options.binning));
  return perception::segment(cloud_C, camera, rendered.scene.camera.X_WC(), options.segmentation,
                             options.table);
}

void measure_solid(const geometry::TriangleMesh& mesh_W, const geometry::TriangleMesh& truth_W,
                   const std::vector<geometry::TriangleMesh>& others_W, MethodResult* result) {
  result->jaccard =
      jaccard_index(geometry::MeshQuery(mesh_W), geometry::MeshQuery(truth_W), kJaccardVoxel);
  const double mass = household_mass(geometry::mass_properties(mesh_W).volume);
  const Settled end = settled(mesh_W, mass, others_W);
  result->moved = end.moved;
  result->turned = end.turned;
}

CaseResult run_case(const Case& one, const std::vector<Method>& methods, bool as_solids) {
  CaseResult result;
  result.case_name = one.name();
  result.group = one.data_set->group;
  result.data_set = one.data_set->name;
  result.orientation = one.orientation;
  result.symmetric = one.data_set->symmetric;

  RenderedScene rendered = scene_of(one);
  const geometry::TriangleMesh& truth_B = *one.data_set->mesh_B;
  geometry::RigidTransform X_WB = one.X_WB();
  std::vector<geometry::TriangleMesh> others_W;
  for (const auto& other_B : one.data_set->viewing.others_B) {
    others_W.push_back(geometry::transformed(*other_B, X_WB));
  }
  if (as_solids) {
    const double mass = household_mass(geometry::mass_properties(truth_B).volume);
    X_WB = resting_pose(truth_B, X_WB, mass, others_W);
    rendered.bodies.front().X_WB = X_WB;
  }
  const geometry::TriangleMesh truth_W = geometry::transformed(truth_B, X_WB);
  simulation::RenderOptions render;
  render.threads = 1;
  const simulation::StereoImages images =
      simulation::render_stereo(rendered.scene, rendered.bodies, 0, render);
  perception::SegmentedScene scene;
  try {
    scene = seen_scene(rendered, images);
  } catch (const std::exception& error) {
    result.problem = error.what();
    return result;
  }
  const std::optional<std::size_t> object = object_of(scene, images.labels);
  if (!object) {
    result.problem = "The object was not found on the table";
    return result;
  }
  const perception::ObjectHypothesis& seen = scene.objects[*object];
  result.points = static_cast<int>(seen.cloud_W.size());
  result.mask_iou = mask_iou(seen.mask, images.labels, 0);

  const geometry::RigidTransform X_BW = X_WB.inverse();
  for (const Method& method : methods) {
    MethodResult measures;
    try {
      const auto [made, spent] = timed_reconstruction(method, scene, *object, truth_W);
      measures = measured(geometry::transformed(made.mesh_W, X_BW), truth_B, one.seed);
      if (as_solids && geometry::find_defects(made.mesh_W).boundary_edges == 0) {
        measure_solid(made.mesh_W, truth_W, others_W, &measures);
      }
      measures.vote = made.vote;
      measures.confidence = made.confidence;
      measures.evidence = made.evidence;
      measures.seconds = spent;
    } catch (const std::exception& error) {
      measures = {};  // a mesh of which not all can be measured is none
      measures.problem = error.what();
    }
    measures.method = method.name;
    result.methods.push_back(measures);
  }
  return result;
}

}  // namespace prehend::eval
