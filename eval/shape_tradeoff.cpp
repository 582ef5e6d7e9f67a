#include "eval/shape_tradeoff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "eval/case_runner.h"
#include "eval/processor_time.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/simulation/stereo_renderer.h"
#include "prehend/surface/model.h"

namespace prehend::eval {
namespace {

using fidelity::Setting;
using perception::StereoMethod;

struct StereoWay {
  const char* name;
  perception::StereoOptions options;
};

std::vector<StereoWay> stereo_ways() {
  perception::StereoOptions block, eight, filtered;
  block.method = StereoMethod::kBlockMatching;
  eight.eight_directions = true;
  filtered.filter = true;
  return {{"semi_global", {}},
          {"block_matching", block},
          {"eight_directions", eight},
          {"semi_global_filtered", filtered}};
}

// What a case's object looks like after matching and segmentation.
struct Seen {
  const Case* one = nullptr;
  perception::SegmentedScene scene;
  std::size_t object = 0;
  double stereo_seconds = 0;
};

std::optional<Seen> seen_by(const Case& one, const RenderedScene& rendered,
                            const simulation::StereoImages& images,
                            const perception::StereoOptions& options) {
  Seen seen;
  seen.one = &one;
  const geometry::StereoCamera& camera = rendered.scene.camera.camera;
  const double start = processor_time();
  const perception::DisparityImage disparity =
      perception::stereo_disparity(images.left, images.right, camera, options);
  seen.stereo_seconds = processor_time() - start;
  perception::SegmentationOptions segmentation;
  segmentation.baseline = camera.baseline;
  try {
    seen.scene =
        perception::segment(perception::cloud_from_disparity(disparity, camera, images.left),
                            camera.left, rendered.scene.camera.X_WC(), segmentation);
  } catch (const geometry::InputError&) {
    return std::nullopt;  // no table: counted as not found
  }
  const std::optional<std::size_t> found = object_of(seen.scene, images.labels);
  if (!found) return std::nullopt;
  seen.object = *found;
  return seen;
}

geometry::TriangleMesh mesh_by(const Seen& seen, const fidelity::ShapeOptions& options) {
  const perception::ObjectHypothesis& object = seen.scene.objects[seen.object];
  const auto shapes = shape::complete_scene(seen.scene, options.completion);
  return surface::mesh_of(shapes[seen.object].get(), support_of(seen.scene, object), options.model);
}

Measured measured_by(const Setting& setting, const std::vector<Seen>& objects, int repetitions) {
  Measured result;
  result.setting = setting;
  result.objects = static_cast<int>(objects.size());
  const fidelity::ShapeOptions options = fidelity::shape_options(setting);
  double seconds = 0, error = 0;
  int meshes = 0;
  for (const Seen& seen : objects) {
    try {
      std::vector<double> times;
      geometry::TriangleMesh mesh;
      for (int r = 0; r < repetitions; ++r) {
        const double start = processor_time();
        mesh = mesh_by(seen, options);
        times.push_back(processor_time() - start);
      }
      std::nth_element(times.begin(), times.begin() + repetitions / 2, times.end());
      error += measured(geometry::transformed(mesh, seen.one->X_WB().inverse()),
                        *seen.one->data_set->mesh_B, 1)
                   .mean;
      seconds += times[static_cast<std::size_t>(repetitions / 2)];
      ++meshes;
    } catch (const geometry::InputError&) {
      ++result.failed;
    }
  }
  result.setting.seconds = meshes > 0 ? seconds / meshes : kUnknown;
  result.setting.error = meshes > 0 ? error / meshes : kUnknown;
  return result;
}

}  // namespace

std::vector<Setting> swept_settings(bool quick) {
  using Knobs = std::vector<std::pair<std::string, std::string>>;
  std::vector<Knobs> list;
  const auto search = [](const char* thinning, const char* orientations, const char* shifts,
                         const char* refine) {
    return Knobs{{"thinning", thinning},
                 {"orientations", orientations},
                 {"shifts", shifts},
                 {"refine", refine}};
  };
  const Knobs searches[] = {search("0.1", "15", "11", "no"), search("0.06", "31", "21", "no"),
                            search("0.04", "31", "21", "yes"), search("0.02", "61", "41", "yes")};
  const Knobs surfaces[] = {{{"spacing", "0.006"}, {"surface", "fast"}, {"resolution", "32"}},
                            {{"spacing", "0.004"}, {"surface", "fast"}, {"resolution", "32"}},
                            {{"spacing", "0.004"}, {"surface", "fast"}, {"resolution", "64"}},
                            {{"spacing", "0.003"}, {"surface", "fast"}, {"resolution", "80"}},
                            {{"spacing", "0"}, {"surface", "fast"}, {"resolution", "64"}},
                            {{"spacing", "0"}, {"surface", "fast"}, {"resolution", "128"}},
                            {{"spacing", "0"}, {"surface", "pcl"}, {"resolution", "5"}},
                            {{"spacing", "0"}, {"surface", "pcl"}, {"resolution", "7"}}};
  std::vector<Setting> settings;
  for (const Knobs& s : searches) {
    for (const Knobs& m : surfaces) {
      // PCL's costs many times the search; it is swept with the finest search alone.
      if (m[1].second == "pcl" && &s != &searches[3]) continue;
      Setting& setting = settings.emplace_back();
      setting.knobs = s;
      setting.knobs.insert(setting.knobs.end(), m.begin(), m.end());
    }
  }
  if (!quick) return settings;
  std::vector<Setting> few;
  for (std::size_t i = 0; i < settings.size(); i += 6) few.push_back(settings[i]);
  return few;
}

ShapeTradeoff measure_shape_tradeoff(const std::vector<Case>& cases,
                                     const std::vector<Setting>& settings, int repetitions,
                                     const std::function<void(const std::string&)>& progress) {
  ShapeTradeoff tradeoff;
  std::vector<Seen> objects;
  const std::vector<StereoWay> ways = stereo_ways();
  std::vector<std::vector<Seen>> by_way(ways.size());
  for (const Case& one : cases) {
    progress("rendering and matching " + one.name());
    const RenderedScene rendered = scene_of(one);
    simulation::RenderOptions render;
    render.threads = 1;
    const simulation::StereoImages images =
        simulation::render_stereo(rendered.scene, rendered.bodies, 0, render);
    for (std::size_t w = 0; w < ways.size(); ++w) {
      if (auto seen = seen_by(one, rendered, images, ways[w].options)) {
        by_way[w].push_back(std::move(*seen));
      }
    }
  }
  if (by_way.front().empty()) {
    throw geometry::InputError(
        "No object was found in any of the " + std::to_string(cases.size()) + " cases",
        "Evaluate larger objects");
  }
  for (const Setting& setting : settings) {
    tradeoff.shape.push_back(measured_by(setting, by_way.front(), repetitions));
    const Measured& m = tradeoff.shape.back();
    progress(fmt::format("{} of {} settings: {:.1f} ms, {:.2f} mm", tradeoff.shape.size(),
                         settings.size(), 1e3 * m.setting.seconds, 1e3 * m.setting.error));
  }
  for (std::size_t w = 0; w < ways.size(); ++w) {
    if (by_way[w].empty()) continue;
    Measured m = measured_by({{{"refine", "yes"}}, 0, 0}, by_way[w], 1);
    m.setting.knobs = {{"stereo", ways[w].name}};
    m.setting.seconds = 0;
    for (const Seen& seen : by_way[w]) {
      m.setting.seconds += seen.stereo_seconds / static_cast<double>(by_way[w].size());
    }
    m.failed += static_cast<int>(cases.size() - by_way[w].size());
    m.objects = static_cast<int>(cases.size());
    tradeoff.stereo.push_back(m);
  }
  return tradeoff;
}

fidelity::Front front_of(const ShapeTradeoff& tradeoff, const std::string& machine) {
  std::vector<Setting> whole;
  for (const Measured& m : tradeoff.shape) {
    if (m.failed == 0) whole.push_back(m.setting);
  }
  fidelity::Front front;
  front.subject = "shape";
  front.error_name = "mean distance of the true surface to the mesh";
  front.machine = machine;
  front.settings = fidelity::pareto_front(std::move(whole));
  return front;
}

}  // namespace prehend::eval
