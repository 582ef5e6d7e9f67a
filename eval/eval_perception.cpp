// Perception against the truth: disparities of a real pair, rendered crowds of objects, labelled
// recordings, views of single bodies.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "eval/case_choice.h"
#include "eval/platform/clutter_cases.h"
#include "eval/segmentation_accuracy.h"
#include "eval/stereo_accuracy.h"
#include "eval/text_files.h"
#include "eval/view_segmentation.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/segmentation.h"
#include "prehend/report/page.h"
#include "prehend/shape/body_evidence.h"
#include "prehend/text/command_line.h"
#include "prehend/text/json.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

using Rows = std::vector<std::vector<std::string>>;

std::string percent(double share) { return fmt::format("{:.2f}", 100 * share); }

const std::vector<std::string> kStereoHeader = {"method",
                                                "matched [%]",
                                                "bad 1 px [%]",
                                                "bad 2 px [%]",
                                                "bad 4 px [%]",
                                                "bad or missing 1 px [%]",
                                                "bad or missing 2 px [%]",
                                                "bad or missing 4 px [%]",
                                                "bad of the surer half [%]",
                                                "bad of the less sure half [%]",
                                                "ms"};

Rows stereo_rows(const std::vector<eval::StereoRun>& runs) {
  Rows rows;
  for (const eval::StereoRun& run : runs) {
    const eval::DisparityErrors& e = run.errors;
    rows.push_back({run.method, percent(e.density), percent(e.bad[0]), percent(e.bad[1]),
                    percent(e.bad[2]), percent(e.bad_or_missing[0]), percent(e.bad_or_missing[1]),
                    percent(e.bad_or_missing[2]), percent(e.sure_bad), percent(e.unsure_bad),
                    fmt::format("{:.0f}", 1e3 * run.seconds)});
  }
  return rows;
}

const std::vector<std::string> kSegmentationHeader = {
    "condition",        "objects",           "found", "missed", "split", "merged", "mask IoU",
    "depth error [mm]", "depth missing [%]", "ms"};

Rows segmentation_rows(const std::vector<eval::SegmentationRun>& runs) {
  Rows rows;
  for (const eval::SegmentationRun& run : runs) {
    const eval::SegmentationErrors& e = run.errors;
    const bool depth = !std::isnan(run.depth_error);
    rows.push_back(
        {run.condition, std::to_string(e.truths), std::to_string(e.found), std::to_string(e.missed),
         std::to_string(e.split), std::to_string(e.merged), fmt::format("{:.3f}", e.iou),
         depth ? fmt::format("{:.2f}", 1e3 * run.depth_error) : "",
         depth ? percent(run.depth_missing) : "", fmt::format("{:.0f}", 1e3 * run.seconds)});
  }
  return rows;
}

std::string to_csv(const std::vector<std::string>& header, const Rows& rows) {
  std::string text;
  const auto add = [&](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      text += (i == 0 ? "\"" : ",\"") + cells[i] + "\"";
    }
    text += '\n';
  };
  add(header);
  for (const auto& row : rows) add(row);
  return text;
}

// A list of objects; cells that are numbers as numbers, empty ones as null.
prehend::text::Json to_json(const std::vector<std::string>& header, const Rows& rows) {
  prehend::text::Json table = prehend::text::Json::array();
  for (const auto& row : rows) {
    prehend::text::Json object = prehend::text::Json::object();
    for (std::size_t i = 0; i < row.size(); ++i) {
      char* end = nullptr;
      const double number = std::strtod(row[i].c_str(), &end);
      const bool is_number = !row[i].empty() && *end == '\0';
      object.set(header[i], row[i].empty() ? prehend::text::Json::null()
                            : is_number    ? prehend::text::Json(number)
                                           : prehend::text::Json(row[i]));
    }
    table.add(object);
  }
  return table;
}

// A table in the page, in a file of its own, in `json` and on the terminal.
void add_table(report::Page& page, prehend::text::Json& json, const fs::path& folder,
               const std::string& name, const std::string& title,
               const std::vector<std::string>& header, const Rows& rows) {
  if (rows.empty()) return;
  json.set(name, to_json(header, rows));
  page.add_heading(title);
  page.add_table(header, rows);
  const std::string csv = to_csv(header, rows);
  eval::write_text(folder / (name + ".csv"), csv);
  std::printf("\n%s\n%s", title.c_str(), csv.c_str());
  std::fflush(stdout);
}

struct Options {
  eval::CaseChoice choice = eval::default_choice("out/perception");
  int scenes = 8;
  int clutter = 28;
  std::string split = "tops";
  double least_split_width = 0;  // m

  perception::SegmentationOptions segmentation() const {
    perception::SegmentationOptions options;
    perception::choose_splitting(split, std::nullopt, &options);
    options.least_split_width = least_split_width;
    options.body_evidence = shape::log_odds_of_one_body;
    return options;
  }
  /// Views that were split otherwise are forgotten.
  eval::CaseRunOptions runs() const {
    eval::CaseRunOptions options = choice.runs;
    options.setting = fmt::format("split {} from {} m", split, least_split_width);
    return options;
  }
};

// The tables of one run, in each of their forms.
struct Tables {
  report::Page page{"Perception against the truth"};
  prehend::text::Json json = prehend::text::Json::object();
  fs::path folder;

  void add(const std::string& name, const std::string& title,
           const std::vector<std::string>& header, const Rows& rows) {
    add_table(page, json, folder, name, title, header, rows);
  }
};

void add_recordings(Tables& tables) {
  const char* shared = std::getenv("PREHEND_SHARED_DATA");
  if (shared == nullptr || *shared == '\0') {
    std::printf("Without real recordings: PREHEND_SHARED_DATA does not name a folder.\n");
    return;
  }
  const fs::path data = shared;
  if (fs::exists(data / "stereo" / "cones")) {
    tables.add("stereo", "Real pair with known disparity (Middlebury cones)", kStereoHeader,
               stereo_rows(eval::compare_stereo_methods(
                   eval::read_middlebury_2003(data / "stereo" / "cones"))));
  }
  tables.add("labelled", "Labelled recordings (OSD)", kSegmentationHeader,
             segmentation_rows(eval::labelled_segmentation(data / "clouds" / "osd")));
}

std::vector<eval::ViewSegmentation> seen_views(const std::vector<eval::Case>& cases,
                                               const Options& options) {
  const eval::CaseRunOptions runs = options.runs();
  const perception::SegmentationOptions segmentation = options.segmentation();
  std::vector<std::string> names;
  for (const eval::Case& one : cases) names.push_back(one.result_name());
  return eval::found_results(eval::run_cases(runs, names, eval::read_view, [&](int i) {
    return eval::segment_view(cases[i], segmentation);
  }));
}

void add_views(const std::vector<eval::ViewSegmentation>& views, Tables& tables) {
  tables.add("groups", "Rendered views of one object and what is beside it, by group",
             kSegmentationHeader, segmentation_rows(eval::by_group(views)));
  tables.add("objects", "The same, by object", kSegmentationHeader,
             segmentation_rows(eval::by_data_set(views)));
}

// Heaps of the household's and scanned things, half of them by either sensor.
void add_clutter(const std::vector<eval::DataSet>& sets, const Options& options, Tables& tables) {
  if (options.clutter == 0) return;
  const auto solids = eval::clutter_solids(sets, 1);
  std::vector<eval::ViewSegmentation> views;
  const auto scenes = eval::of_each_seed(options.choice, [&](std::uint64_t seed) {
    return eval::clutter_cases(options.clutter, seed);
  });
  for (const eval::ClutterCase& one : scenes) {
    for (const auto sensor : {eval::DepthSensor::kStereo, eval::DepthSensor::kStructuredLight}) {
      views.push_back(eval::clutter_view(one, solids, sensor, options.segmentation()));
    }
    std::fprintf(stderr, "\rclutter: %zu of %zu scenes", views.size() / 2, scenes.size());
  }
  std::fprintf(stderr, "\n");
  tables.add("clutter", "Generated clutter, 1 to 12 objects a scene", kSegmentationHeader,
             segmentation_rows(eval::by_group(views)));
}

int run(const Options& options) {
  if (options.least_split_width > 0 && options.split != "shapes") {
    throw geometry::InputError("--least-split-width is of --split shapes, not of " + options.split,
                               "Leave it away, or split by shapes");
  }
  const std::vector<eval::DataSet> sets = eval::chosen_data_sets(options.choice);
  const std::vector<eval::Case> cases = eval::chosen_cases(sets, options.choice);
  if (options.choice.list) return eval::list_cases(cases);
  cv::setNumThreads(1);
  // First: other ranks end here, and do and write nothing of the rest.
  const std::vector<eval::ViewSegmentation> views = seen_views(cases, options);
  Tables tables;
  tables.folder = options.choice.runs.out;
  if (options.choice.groups.empty() && options.choice.meshes.empty()) {
    add_recordings(tables);
    for (const std::uint64_t seed : options.choice.seeds) {
      const std::string name = fmt::format("rendered_seed{}", seed);
      tables.add(options.choice.seeds.size() > 1 ? name : "rendered",
                 fmt::format("Rendered tables, four objects each, seed {}", seed),
                 kSegmentationHeader,
                 segmentation_rows(
                     eval::rendered_segmentation(options.scenes, seed, options.segmentation())));
    }
    add_clutter(sets, options, tables);
  }
  add_views(views, tables);
  tables.page.write(tables.folder / "index.html");
  if (!options.choice.json.empty()) eval::write_text(options.choice.json, tables.json.pretty());
  std::printf("\n%s\n", (tables.folder / "index.html").c_str());
  return views.size() == cases.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Perception against the truth: disparities and labels of real recordings where "
      "PREHEND_SHARED_DATA names their folder, rendered tables with four objects each, generated "
      "clutter, and views of single bodies with all that is beside them. With --groups or --meshes "
      "only the views. "
      "A run that was interrupted goes on with the views that are missing.");
  eval::add_case_options(app, options.choice);
  app.add_option("--scenes", options.scenes, "tables rendered for each condition")
      ->check(text::in_range(1, 1000))
      ->capture_default_str()
      ->excludes("--groups")
      ->excludes("--meshes");
  app.add_option("--clutter", options.clutter,
                 "scenes of things that touch, lie on, lean on and hide one another; 0: none")
      ->check(text::in_range(0, 10000))
      ->capture_default_str()
      ->excludes("--groups")
      ->excludes("--meshes");
  app.add_option("--split", options.split, "what takes things apart that touch")
      ->check(CLI::IsMember({"none", "tops", "touching", "shapes"}))
      ->capture_default_str();
  app.add_option("--least-split-width", options.least_split_width,
                 "of --split shapes: what is narrower across the table stays whole [m]")
      ->check(text::in_range(0.0, 1.0))
      ->capture_default_str();
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
