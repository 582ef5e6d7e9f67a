#include "eval/platform/clutter_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "eval/platform/table_scene.h"
#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

constexpr double kLargestInClutter = 0.2;  // m
constexpr int kDirections = 36;

// m, across the narrowest horizontal direction
double width_of(const geometry::TriangleMesh& mesh) {
  double width = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kDirections; ++k) {
    const double angle = std::numbers::pi * k / kDirections;
    const Eigen::Vector3d along(std::cos(angle), std::sin(angle), 0);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Eigen::Vector3d& p : mesh.vertices) {
      low = std::min(low, along.dot(p));
      high = std::max(high, along.dot(p));
    }
    width = std::min(width, high - low);
  }
  return width;
}

}  // namespace

std::vector<simulation::ClutterSolid> clutter_solids(const std::vector<DataSet>& sets,
                                                     double widest) {
  std::vector<simulation::ClutterSolid> solids;
  for (const DataSet& set : sets) {
    if (!set.viewing.others_B.empty() ||
        geometry::bounds(*set.mesh_B).sizes().maxCoeff() > kLargestInClutter) {
      continue;
    }
    const PlacedBody body = resting_body(set);
    if (width_of(*body.mesh_B) > widest) continue;
    solids.push_back({body.name, body.mesh_B, body.mass});
  }
  if (solids.empty()) {
    throw geometry::InputError(
        fmt::format("No body of the chosen groups stands alone, is at most {} m large and at most "
                    "{} m wide",
                    kLargestInClutter, widest),
        "Choose other --groups or --meshes, or a greater --widest");
  }
  return solids;
}

std::vector<ClutterCase> clutter_cases(int count, std::uint64_t seed) {
  static constexpr const char* kKinds[] = {"apart",  "touching", "stacked", "leaning",
                                           "hidden", "tumbled",  "mixed"};
  std::vector<ClutterCase> cases;
  for (int i = 0; i < count; ++i) {
    ClutterCase one;
    one.kind = kKinds[static_cast<std::size_t>(i) % std::size(kKinds)];
    one.name = fmt::format("scene_{:03}_{}-seed{}", i, one.kind, seed);
    one.varied = 1;
    simulation::ClutterOptions& options = one.options;
    options.count = 1 + (i * 5 + 2) % 12;
    options.center = {0, -0.06};
    options.size = {0.34, 0.4};
    options.seed = seed * 1000003 + static_cast<std::uint64_t>(i);
    if (one.kind == "touching") options.touching = 1;
    if (one.kind == "stacked") options.stacked = 0.6;
    if (one.kind == "leaning") options.leaning = 0.6;
    if (one.kind == "hidden") options.hidden = 0.8;
    if (one.kind == "tumbled") options.tumbled = 1;
    if (one.kind == "mixed") {
      options.touching = options.stacked = options.leaning = options.hidden = 0.2;
      options.tumbled = 0.3;
    }
    cases.push_back(one);
  }
  return cases;
}

ViewSegmentation clutter_view(const ClutterCase& one,
                              const std::vector<simulation::ClutterSolid>& solids,
                              DepthSensor sensor,
                              const perception::SegmentationOptions& segmentation) {
  const auto bodies = simulation::drop_clutter(solids, one.options);
  RenderedScene rendered;
  rendered.scene = simulation::clutter_scene(solids, bodies, "", one.varied, one.options.seed);
  rendered.sensor = sensor;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& mesh = solids[bodies[i].solid].mesh_B;
    rendered.bodies.push_back({bodies[i].name, mesh, bodies[i].X_WB,
                               rendered.scene.objects[i].texture,
                               geometry::bounds(*mesh).max().z()});
  }
  const char* by = sensor == DepthSensor::kStereo ? "stereo" : "structured light";
  return {one.name, one.kind + ", " + by, one.name, segment_rendered(rendered, segmentation)};
}

}  // namespace prehend::eval
