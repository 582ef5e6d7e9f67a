#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/calibration/work_area.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/report/charts.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {
namespace {

using calibration::TableView;
using calibration::WorkAreaFit;

std::vector<TableView> read_views(const std::string& file) {
  std::vector<TableView> views;
  if (std::filesystem::path(file).extension() != ".csv") {
    TableView view;
    view.name = file;
    view.cloud_C = geometry::read_cloud_file(file).cloud;
    views.push_back(std::move(view));
    return views;
  }
  const text::CsvTable table =
      text::read_csv_table(file, 1, "Write a row for each cloud: cloud,x,y,z,qw,qx,qy,qz");
  const int column = table.require("cloud", "a file, from this one's folder");
  const std::vector<geometry::RigidTransform> poses = poses_of(table);
  for (std::size_t r = 0; r < poses.size(); ++r) {
    TableView view;
    view.name = table.rows[r][static_cast<std::size_t>(column)];
    view.cloud_C = geometry::read_cloud_file(beside(table, view.name)).cloud;
    view.X_AC = poses[r];
    views.push_back(std::move(view));
  }
  return views;
}

std::string list_of(const Eigen::Vector3d& v, int digits) {
  return fmt::format("[{:.{}f}, {:.{}f}, {:.{}f}]", v.x(), digits, v.y(), digits, v.z(), digits);
}

}  // namespace

void run_calibrate_table(const CalibrateChoices& choices) {
  if (choices.inputs.size() != 1) {
    throw std::invalid_argument(
        "give one cloud, or one CSV file of clouds with the camera's poses");
  }
  const std::vector<TableView> views = read_views(choices.inputs.front());
  const WorkAreaFit fit = calibration::calibrate_work_area(views);
  for (const auto& view : fit.views) {
    std::printf("%s: %d points on the table, %.2f mm from the plane, tilted by %.3f degrees\n",
                view.name.c_str(), view.points, 1e3 * view.rms, view.tilt * 180 / M_PI);
  }
  std::printf("plane %s . p = %.5f m; work area %.4f m x %.4f m\n",
              list_of(fit.plane_A.normal, 5).c_str(), fit.plane_A.offset, fit.length, fit.width);
  for (const std::string& remark : fit.remarks) std::printf("  missing: %s\n", remark.c_str());
  const std::string page_name = page_file(choices);
  if (!page_name.empty()) {
    report::Page page("The work area");
    page.add_paragraph(fmt::format(
        "Plane {} . p = {:.5f} m, points {:.2f} mm from it (root mean square); {:.4f} m x {:.4f} "
        "m.",
        list_of(fit.plane_A.normal, 5), fit.plane_A.offset, 1e3 * fit.rms, fit.length, fit.width));
    for (const std::string& remark : fit.remarks) page.add_answer(remark);
    std::vector<std::vector<std::string>> edges, of_views;
    report::BarChart bars;
    bars.title = "Distance from the common plane";
    bars.y_label = "[mm]";
    bars.series = {{"root mean square", {}}, {"mean", {}}};
    for (std::size_t i = 0; i < fit.edges.size(); ++i) {
      const calibration::WorkAreaEdge& edge = fit.edges[i];
      edges.push_back({std::to_string(i + 1), list_of(edge.from_A, 4), list_of(edge.to_A, 4),
                       fmt::format("{:.2f}", 1e3 * edge.rms),
                       edge.is_real ? "edge" : "end of the image"});
    }
    for (std::size_t i = 0; i < fit.views.size(); ++i) {
      const calibration::TableViewFit& view = fit.views[i];
      bars.categories.push_back(std::to_string(i + 1));
      bars.series[0].values.push_back(1e3 * view.rms);
      bars.series[1].values.push_back(1e3 * view.mean);
      of_views.push_back({std::to_string(i + 1), view.name, std::to_string(view.points),
                          fmt::format("{:.3f}", view.tilt * 180 / M_PI)});
    }
    page.add_table({"", "from [m]", "to [m]", "rms [mm]", ""}, edges);
    page.add_chart(report::draw_bar_chart(bars), "Views by their number in the table below.");
    page.add_table({"", "view", "points", "tilt [degrees]"}, of_views);
    write_page(page_name, page);
  }
  if (!choices.out.empty()) {
    std::string text = fmt::format(
        "# Found by `prehend calibrate table`. Frame: {}.\nplane: {{normal: {}, offset: {:.6f}}}  "
        "# "
        "normal . p = offset [m]\nlength: {:.5f}  # m\nwidth: {:.5f}  # m\ncorners:  # m, right "
        "hand "
        "about the normal",
        views.front().X_AC ? "that of the camera's poses" : "the camera's optical one",
        list_of(fit.plane_A.normal, 8), fit.plane_A.offset, fit.length, fit.width);
    for (const auto& edge : fit.edges) {
      text += fmt::format("\n  - {}{}", list_of(edge.from_A, 6),
                          edge.is_real ? "" : "  # the edge from here is the end of the image");
    }
    write_result(choices.out, text, "The work area");
  }
}

}  // namespace prehend::tools
