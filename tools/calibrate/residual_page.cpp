#include <cmath>

#include <fmt/format.h>

#include "prehend/report/charts.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {

void add_camera_residuals(report::Page& page, const calibration::CameraFit& fit) {
  std::vector<std::vector<std::string>> rows;
  report::BarChart bars;
  bars.title = "Reprojection of each view";
  bars.y_label = "root mean square [pixels]";
  bars.series.push_back({"view", {}});
  for (std::size_t i = 0; i < fit.views.size(); ++i) {
    const calibration::ViewFit& view = fit.views[i];
    rows.push_back({std::to_string(i + 1), view.name, std::to_string(view.corners),
                    view.rms > 0 ? fmt::format("{:.3f}", view.rms) : "-",
                    view.used ? "used" : view.why_not});
    bars.categories.push_back(std::to_string(i + 1));
    bars.series.front().values.push_back(view.used ? view.rms : std::nan(""));
  }
  page.add_chart(report::draw_bar_chart(bars), "Views by their number in the table below.");
  report::LineChart scatter;
  scatter.title = "Residuals of all corners";
  scatter.x_label = "to the right [pixels]";
  scatter.y_label = "down [pixels]";
  report::Series residuals{"corner", {}, {}, false}, places{"corner", {}, {}, false};
  for (const calibration::CornerFit& corner : fit.corners) {
    residuals.points.emplace_back(corner.residual.x(), corner.residual.y());
    places.points.emplace_back(corner.pixel.x(), fit.calibration.height - 1 - corner.pixel.y());
  }
  scatter.series.push_back(residuals);
  page.add_chart(report::draw_line_chart(scatter),
                 "Found minus predicted: a round cloud about zero, or the model is not the lens'.");
  report::LineChart cover;
  cover.title = "Where corners were";
  cover.x_label = "column [pixels]";
  cover.y_label = "height over the lowest row [pixels]";
  cover.series.push_back(places);
  page.add_chart(report::draw_line_chart(cover), "Outside of them the lens is extrapolated.");
  page.add_table({"", "image", "corners", "rms [pixels]", ""}, rows);
}

}  // namespace prehend::tools
