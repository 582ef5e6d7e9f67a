#include "eval/segmentation_accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include "eval/data_sets.h"
#include "eval/household_objects.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/recorded_cloud.h"
#include "prehend/perception/refinement.h"
#include "prehend/perception/stereo.h"
#include "prehend/shape/body_evidence.h"
#include "prehend/simulation/stereo_renderer.h"

namespace prehend::eval {
namespace {

using geometry::MaskImage;
using perception::SegmentedScene;

// Four household objects on a table, two of them close together.
RenderedScene crowd(const std::vector<DataSet>& sets, const Appearance& appearance,
                    std::mt19937_64& random) {
  static constexpr double kPlaces[4][2] = {{0, -0.16}, {-0.02, 0.15}, {-0.2, 0}, {0.12, 0.04}};
  RenderedScene scene;
  for (int k = 0; k < 4; ++k) {
    const Case one{&sets[random() % sets.size()], static_cast<int>(random() % 360),
                   random() % 1000};
    RenderedScene single = scene_of(one, appearance);
    simulation::VisibleBody body = single.bodies.front();
    body.name += std::to_string(k);
    body.X_WB.translation() = Eigen::Vector3d(kPlaces[k][0], kPlaces[k][1], 0);
    if (k == 0) scene.scene = single.scene;
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

struct Knobs {
  perception::StereoOptions stereo;
  perception::SegmentationOptions segmentation;
  bool refine = false;
};

// Adds one scene to a run.
void add_scene(const RenderedScene& rendered, const simulation::StereoImages& images,
               const Knobs& knobs, SegmentationRun& run, DepthErrors& depth) {
  const geometry::StereoCamera& camera = rendered.scene.camera.camera;
  const auto start = std::chrono::steady_clock::now();
  SegmentedScene scene;
  perception::StereoMatch match;
  perception::SegmentationOptions segmentation = knobs.segmentation;
  segmentation.baseline = camera.baseline;
  try {
    match = perception::match_stereo(images.left, images.right, camera, knobs.stereo);
    scene =
        perception::segment(perception::cloud_from_disparity(match.disparity, camera, images.left),
                            camera.left, rendered.scene.camera.X_WC(), segmentation);
    if (knobs.refine) perception::refine_masks(scene, images.left);
  } catch (const geometry::InputError&) {
    scene.objects.clear();  // no table: everything is missed
  }
  run.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  run.errors = run.errors + segmentation_errors(masks_of(scene), images.labels);
  depth.add(perception::depth_from_disparity(match.disparity, camera), images);
}

SegmentationRun run_scenes(const std::string& condition, const std::vector<DataSet>& sets,
                           const Appearance& appearance, const Knobs& knobs, int scenes,
                           std::uint64_t seed) {
  SegmentationRun run;
  run.condition = condition;
  std::mt19937_64 random(seed);  // the same scenes for every condition
  DepthErrors depth;
  for (int s = 0; s < scenes; ++s) {
    const RenderedScene rendered = crowd(sets, appearance, random);
    add_scene(rendered, simulation::render_stereo(rendered.scene, rendered.bodies), knobs, run,
              depth);
  }
  run.seconds /= scenes;
  run.depth_missing = depth.missing_share();
  run.depth_error = depth.median();
  return run;
}

}  // namespace

std::vector<MaskImage> masks_of(const SegmentedScene& scene) {
  std::vector<MaskImage> masks;
  for (const auto& object : scene.objects) masks.push_back(object.mask);
  return masks;
}

void DepthErrors::add(const geometry::DepthImage& depth, const simulation::StereoImages& truth) {
  for (std::size_t i = 0; i < depth.data.size(); ++i) {
    if (truth.labels.data[i] < 0) continue;
    pixels += 1;
    if (std::isnan(depth.data[i])) {
      missing += 1;
    } else {
      off.push_back(std::abs(static_cast<double>(depth.data[i] - truth.depth.data[i])));
    }
  }
}

double DepthErrors::median() const {
  if (off.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted = off;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

SegmentationErrors segmentation_errors(const std::vector<MaskImage>& masks,
                                       const geometry::Image<std::int16_t>& labels, int least) {
  std::int16_t most = -1;
  for (const std::int16_t label : labels.data) most = std::max(most, label);
  const auto count = static_cast<std::size_t>(most + 1);
  std::vector<double> truth(count, 0);
  for (const std::int16_t label : labels.data) {
    if (label >= 0) truth[label] += 1;
  }
  std::vector<std::vector<double>> both(masks.size(), std::vector<double>(count, 0));
  std::vector<double> size(masks.size(), 0);
  for (std::size_t m = 0; m < masks.size(); ++m) {
    if (masks[m].data.size() != labels.data.size()) {
      throw std::invalid_argument("segmentation_errors: masks and labels differ in size");
    }
    for (std::size_t i = 0; i < labels.data.size(); ++i) {
      if (masks[m].data[i] == 0) continue;
      size[m] += 1;
      if (labels.data[i] >= 0) both[m][labels.data[i]] += 1;
    }
  }
  SegmentationErrors errors;
  errors.found = static_cast<int>(masks.size());
  double sum = 0;
  for (std::size_t t = 0; t < count; ++t) {
    if (truth[t] < least) continue;
    ++errors.truths;
    double best = 0, covered = 0;
    int on_it = 0;
    for (std::size_t m = 0; m < masks.size(); ++m) {
      best = std::max(best, both[m][t] / (truth[t] + size[m] - both[m][t]));
      covered = std::max(covered, both[m][t] / truth[t]);
      on_it += both[m][t] > 0.5 * size[m];
    }
    sum += best;
    errors.missed += covered < 0.5;
    errors.split += on_it > 1;
  }
  for (std::size_t m = 0; m < masks.size(); ++m) {
    int covers = 0;
    for (std::size_t t = 0; t < count; ++t) {
      covers += truth[t] >= least && both[m][t] > 0.5 * truth[t];
    }
    errors.merged += covers > 1;
  }
  errors.iou = errors.truths > 0 ? sum / errors.truths : 0;
  return errors;
}

SegmentationErrors operator+(const SegmentationErrors& a, const SegmentationErrors& b) {
  SegmentationErrors sum{a.truths + b.truths, a.found + b.found, a.missed + b.missed,
                         a.merged + b.merged, a.split + b.split, 0};
  if (sum.truths > 0) sum.iou = (a.iou * a.truths + b.iou * b.truths) / sum.truths;
  return sum;
}

std::vector<SegmentationRun> rendered_segmentation(
    int scenes, std::uint64_t seed, const perception::SegmentationOptions& segmentation) {
  const std::vector<DataSet> sets = make_data_sets("household", household_objects());
  std::vector<SegmentationRun> runs;
  Knobs defaults;
  defaults.segmentation = segmentation;
  const auto add = [&](const std::string& name, const Appearance& appearance, const Knobs& knobs) {
    runs.push_back(run_scenes(name, sets, appearance, knobs, scenes, seed));
  };
  for (const auto& [name, contrast] :
       {std::pair{"strong texture", 0.6}, std::pair{"medium texture", 0.35},
        std::pair{"weak texture", 0.1}, std::pair{"no texture", 0.0}}) {
    for (const auto& [light, ambient] :
         {std::pair{"soft light", 0.8}, std::pair{"hard shadows", 0.25}}) {
      add(fmt::format("{}, {}", name, light), {contrast, 2, ambient}, defaults);
    }
  }
  add("medium texture, noise of 8 grey levels", {0.35, 8, 0.45}, defaults);
  const auto with = [&defaults](const std::function<void(Knobs&)>& change) {
    Knobs knobs = defaults;
    change(knobs);
    return knobs;
  };
  add("medium: default", {}, defaults);
  add("medium: organized components", {},
      with([](Knobs& k) { k.segmentation.clustering = perception::Clustering::kOrganized; }));
  add("medium: not split", {},
      with([](Knobs& k) { k.segmentation.split = perception::Splitting::kNone; }));
  add("medium: touching objects split", {},
      with([](Knobs& k) { k.segmentation.split = perception::Splitting::kTouching; }));
  add("medium: split by shapes", {}, with([](Knobs& k) {
        k.segmentation.split = perception::Splitting::kShapes;
        k.segmentation.body_evidence = shape::log_odds_of_one_body;
      }));
  add("medium: masks by graph cut", {}, with([](Knobs& k) { k.refine = true; }));
  add("medium: filtered stereo", {}, with([](Knobs& k) { k.stereo.filter = true; }));
  add("medium: block matching", {},
      with([](Knobs& k) { k.stereo.method = perception::StereoMethod::kBlockMatching; }));
  return runs;
}

std::vector<SegmentationRun> labelled_segmentation(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".pcd") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<SegmentationRun> runs;
  if (files.empty()) return runs;
  for (const auto& [name, clustering, split] :
       {std::tuple{"Euclidean clusters, not split", perception::Clustering::kEuclidean,
                   perception::Splitting::kNone},
        std::tuple{"Euclidean clusters, split by level tops", perception::Clustering::kEuclidean,
                   perception::Splitting::kTops},
        std::tuple{"organized components, split by level tops", perception::Clustering::kOrganized,
                   perception::Splitting::kTops},
        std::tuple{"Euclidean clusters, split by shapes", perception::Clustering::kEuclidean,
                   perception::Splitting::kShapes},
        std::tuple{"organized components, touching objects split",
                   perception::Clustering::kOrganized, perception::Splitting::kTouching}}) {
    SegmentationRun run;
    run.condition = name;
    run.depth_error = std::numeric_limits<double>::quiet_NaN();
    for (const std::filesystem::path& file : files) {
      const perception::RecordedCloud recorded =
          perception::interpret_recorded_cloud(geometry::read_cloud_file(file));
      perception::SegmentationOptions options;
      options.clustering = clustering;
      options.split = split;
      options.body_evidence = shape::log_odds_of_one_body;
      const auto start = std::chrono::steady_clock::now();
      const SegmentedScene scene = perception::segment_recorded_cloud(recorded, options);
      run.seconds +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
          static_cast<double>(files.size());
      geometry::Image<std::int16_t> labels(recorded.cloud_C.width, recorded.cloud_C.height, -1);
      for (std::size_t i = 0; i < recorded.labels.size(); ++i) {
        // 20-29 the first object, 30-39 the second ...; below: nothing and table.
        if (recorded.labels[i] >= 20) {
          labels.data[i] = static_cast<std::int16_t>(recorded.labels[i] / 10 - 2);
        }
      }
      run.errors = run.errors + segmentation_errors(masks_of(scene), labels);
    }
    runs.push_back(run);
  }
  return runs;
}

}  // namespace prehend::eval
