#include "eval/view_segmentation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include <yaml-cpp/yaml.h>

#include "eval/case_runner.h"
#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

struct ViewCount {
  const char* name;
  int SegmentationErrors::*value;
};
constexpr ViewCount kViewCounts[] = {{"truths", &SegmentationErrors::truths},
                                     {"found", &SegmentationErrors::found},
                                     {"missed", &SegmentationErrors::missed},
                                     {"merged", &SegmentationErrors::merged},
                                     {"split", &SegmentationErrors::split}};
struct ViewFigure {
  const char* name;
  double SegmentationRun::*value;
};
constexpr ViewFigure kViewFigures[] = {{"depth_error", &SegmentationRun::depth_error},
                                       {"depth_missing", &SegmentationRun::depth_missing},
                                       {"seconds", &SegmentationRun::seconds}};

// Of all views whose condition is the same.
std::vector<SegmentationRun> combined(
    const std::vector<ViewSegmentation>& views,
    const std::function<std::string(const ViewSegmentation&)>& condition_of) {
  struct Sums {
    SegmentationRun run;
    int views = 0;
    int with_depth = 0;
  };
  std::vector<Sums> sums;
  for (const ViewSegmentation& view : views) {
    const std::string condition = condition_of(view);
    auto at = std::find_if(sums.begin(), sums.end(),
                           [&](const Sums& one) { return one.run.condition == condition; });
    if (at == sums.end()) {
      at = sums.insert(sums.end(), Sums{});
      at->run.condition = condition;
    }
    at->run.errors = at->run.errors + view.seen.errors;
    at->run.depth_missing += view.seen.depth_missing;
    at->run.seconds += view.seen.seconds;
    ++at->views;
    if (std::isnan(view.seen.depth_error)) continue;
    at->run.depth_error += view.seen.depth_error;
    ++at->with_depth;
  }
  std::vector<SegmentationRun> runs;
  for (Sums& one : sums) {
    one.run.depth_missing /= one.views;
    one.run.seconds /= one.views;
    one.run.depth_error = one.with_depth > 0 ? one.run.depth_error / one.with_depth
                                             : std::numeric_limits<double>::quiet_NaN();
    runs.push_back(one.run);
  }
  return runs;
}

}  // namespace

SegmentationRun segment_rendered(const RenderedScene& rendered,
                                 const perception::SegmentationOptions& segmentation) {
  SegmentationRun seen;
  simulation::RenderOptions render;
  render.threads = 1;  // processes share the cores
  const simulation::StereoImages images =
      simulation::render_stereo(rendered.scene, rendered.bodies, 0, render);
  const auto start = std::chrono::steady_clock::now();
  const geometry::DepthImage depth = seen_depth(rendered, images);
  perception::SegmentedScene scene;
  try {
    scene = seen_scene(rendered, images, depth, segmentation);
  } catch (const geometry::InputError&) {
    scene.objects.clear();  // no table: everything is missed
  }
  seen.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  seen.errors = segmentation_errors(masks_of(scene), images.labels);
  DepthErrors errors;
  errors.add(depth, images);
  seen.depth_error = errors.median();
  seen.depth_missing = errors.missing_share();
  return seen;
}

ViewSegmentation segment_view(const Case& one,
                              const perception::SegmentationOptions& segmentation) {
  return {one.name(), one.data_set->group, one.data_set->name,
          segment_rendered(scene_of(one), segmentation)};
}

std::string to_text(const ViewSegmentation& view) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::BeginMap;
  const auto put = [&out](const char* key, const auto& value) {
    out << YAML::Key << key << YAML::Value << value;
  };
  put("case", view.case_name);
  put("group", view.group);
  put("data_set", view.data_set);
  for (const ViewCount& count : kViewCounts) put(count.name, view.seen.errors.*count.value);
  put("iou", view.seen.errors.iou);
  for (const ViewFigure& figure : kViewFigures) put(figure.name, view.seen.*figure.value);
  out << YAML::EndMap;
  return out.c_str();
}

ViewSegmentation read_view(const std::string& text) {
  try {
    const YAML::Node node = YAML::Load(text);
    ViewSegmentation view;
    view.case_name = node["case"].as<std::string>();
    view.group = node["group"].as<std::string>();
    view.data_set = node["data_set"].as<std::string>();
    for (const ViewCount& count : kViewCounts) {
      view.seen.errors.*count.value = node[count.name].as<int>();
    }
    view.seen.errors.iou = node["iou"].as<double>();
    for (const ViewFigure& figure : kViewFigures) {
      view.seen.*figure.value = node[figure.name].as<double>();
    }
    return view;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result of a view: ") + error.what(),
                               "Run the case again");
  }
}

std::vector<SegmentationRun> by_group(const std::vector<ViewSegmentation>& views) {
  return combined(views, [](const ViewSegmentation& view) { return view.group; });
}

std::vector<SegmentationRun> by_data_set(const std::vector<ViewSegmentation>& views) {
  return combined(views,
                  [](const ViewSegmentation& view) { return view.group + ": " + view.data_set; });
}

}  // namespace prehend::eval
