// Perception against the truth: disparities of a real pair, rendered crowds of objects, labelled
// recordings.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "eval/segmentation_accuracy.h"
#include "eval/stereo_accuracy.h"
#include "eval/text_files.h"
#include "prehend/report/page.h"
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

}  // namespace

int main(int argc, char** argv) {
  fs::path out = "out/perception";
  fs::path json_file;
  int scenes = 8;
  std::uint64_t seed = 1;
  CLI::App app(
      "Perception against the truth: disparities and labels of real recordings where "
      "PREHEND_SHARED_DATA names their folder, and rendered tables with four objects each.");
  app.add_option("--out", out, "folder of the page and its tables")->capture_default_str();
  app.add_option("--json", json_file, "file for the tables as JSON");
  app.add_option("--scenes", scenes, "rendered for each condition")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--seed", seed, "of the rendered scenes")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    cv::setNumThreads(1);
    report::Page page("Perception against the truth");
    prehend::text::Json json = prehend::text::Json::object();
    const char* shared = std::getenv("PREHEND_SHARED_DATA");
    if (shared != nullptr && *shared != '\0') {
      const fs::path data = shared;
      if (fs::exists(data / "stereo" / "cones")) {
        add_table(page, json, out, "stereo", "Real pair with known disparity (Middlebury cones)",
                  kStereoHeader,
                  stereo_rows(eval::compare_stereo_methods(
                      eval::read_middlebury_2003(data / "stereo" / "cones"))));
      }
      add_table(page, json, out, "labelled", "Labelled recordings (OSD)", kSegmentationHeader,
                segmentation_rows(eval::labelled_segmentation(data / "clouds" / "osd")));
    } else {
      std::printf("Without real recordings: PREHEND_SHARED_DATA does not name a folder.\n");
    }
    add_table(page, json, out, "rendered", "Rendered tables, four objects each",
              kSegmentationHeader, segmentation_rows(eval::rendered_segmentation(scenes, seed)));
    page.write(out / "index.html");
    if (!json_file.empty()) eval::write_text(json_file, json.pretty());
    std::printf("\n%s\n", (out / "index.html").c_str());
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
