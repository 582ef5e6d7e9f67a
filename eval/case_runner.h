#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/case_result.h"
#include "eval/data_sets.h"
#include "eval/reconstruction_methods.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/perception/segmentation.h"
#include "prehend/simulation/stereo_renderer.h"

namespace prehend::eval {

/// Intersection over union of a mask with the pixels whose label is `label`; 0 when both are empty.
double mask_iou(const geometry::MaskImage& mask, const geometry::Image<std::int16_t>& labels,
                std::int16_t label);

/// The object whose mask has the largest overlap with body 0's pixels, of which a mask's pixel may
/// cover several; none when all have little.
std::optional<std::size_t> object_of(const perception::SegmentedScene& scene,
                                     const geometry::Image<std::int16_t>& labels);

/// What the scene's sensor measures: stereo matching of the rendered pair, or structured light.
geometry::DepthImage seen_depth(const RenderedScene& rendered,
                                const simulation::StereoImages& images);

/// What segmentation makes of that depth.
/// @throws geometry::InputError when it finds no table.
perception::SegmentedScene seen_scene(const RenderedScene& rendered,
                                      const simulation::StereoImages& images,
                                      const geometry::DepthImage& depth,
                                      const perception::SegmentationOptions& options = {});

/// The same of a cloud in the frame of the left camera, as seen_cloud().
perception::SegmentedScene seen_scene(const RenderedScene& rendered,
                                      const geometry::PointCloud& cloud_C,
                                      const fidelity::SeeingOptions& options);

/// What the scene's sensor measures, as a cloud with the left image's colours.
geometry::PointCloud seen_cloud(const RenderedScene& rendered,
                                const simulation::StereoImages& images);

/// Both, as `options` say; masks and camera are binned by them.
perception::SegmentedScene seen_scene(const RenderedScene& rendered,
                                      const simulation::StereoImages& images,
                                      const fidelity::SeeingOptions& options = {});

/// Renders the case's stereo pair, matches it, segments it and lets each method complete the object
/// at the table's centre; then measures each mesh against the truth in its known pose.
///
/// `mean`, `variance` ... are over 10,000 points spread uniformly over the area of the truth, each
/// with its distance to the mesh, as MeshDev measures (Roy, Foufou, Truchetet: "Mesh comparison
/// using attribute deviation metric", 2004). The centroid of a surface is that of its area, which
/// meshes with a boundary have, too. What fails is in the result's `problem`s; only a bug throws.
/// @param as_solids the object comes to rest on the table first (resting_pose()), and each mesh
/// that is closed is measured by measure_solid(), too
CaseResult run_case(const Case& one, const std::vector<Method>& methods, bool as_solids = false);

/// What measure_solid() counts by.
constexpr double kJaccardVoxel = 0.003;  // m

/// Adds the Jaccard index of a closed mesh and how far it goes when it is let go on the table, with
/// the mass of a household thing of its volume, among `others_W`.
/// @throws geometry::InputError for a mesh that encloses no volume.
void measure_solid(const geometry::TriangleMesh& mesh_W, const geometry::TriangleMesh& truth_W,
                   const std::vector<geometry::TriangleMesh>& others_W, MethodResult* result);

/// The distances of a mesh in the body's frame B to the truth in B; `seed` is of the sampling.
MethodResult measured(const geometry::TriangleMesh& mesh_B, const geometry::TriangleMesh& truth_B,
                      std::uint64_t seed);

}  // namespace prehend::eval
