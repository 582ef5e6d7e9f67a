#include "prehend/report/front_chart.h"

#include <algorithm>
#include <functional>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/report/charts.h"
#include "prehend/report/page.h"

namespace prehend::report {
namespace {

constexpr int kChartWidth = 600;  // pixels: two of them stand side by side

using Drawn = std::function<double(const FrontPoint&)>;

// A chain's points are no line: of two that are alike in one error the slower one is better in the
// other.
std::string draw_front(const DrawnFront& front, const std::string& y_label, const Drawn& y) {
  Series others{"measured", {}, {}, false}, chosen{"chosen", {}, {}, false};
  for (std::size_t i = 0; i < front.points.size(); ++i) {
    Series& series = i == front.chosen ? chosen : others;
    series.points.emplace_back(front.points[i].seconds, y(front.points[i]));
  }
  LineChart chart{"", "processor time [s]", y_label, {chosen}, {}, kChartWidth};
  if (!others.points.empty()) chart.series.push_back(others);
  if (front.budget > 0) chart.markers.push_back({front.budget, "budget"});
  return draw_line_chart(chart);
}

std::string draw_error(const DrawnFront& front) {
  const bool is_length = front.error_unit == "m";
  const bool is_share = front.error_unit.rfind("of ", 0) == 0;
  const double factor = is_length ? 1e3 : is_share ? 100 : 1;
  const std::string unit = is_length ? "mm" : is_share ? "% " + front.error_unit : front.error_unit;
  return draw_front(front, fmt::format("error [{}]", unit),
                    [factor](const FrontPoint& point) { return factor * point.error; });
}

}  // namespace

std::string front_text(const DrawnFront& front) {
  const std::string asked = front.budget > 0
                                ? fmt::format("A budget of {:.4g} s", front.budget)
                                : fmt::format("A tolerance of {:.4g} mm", 1e3 * front.tolerance);
  return fmt::format("{}{} chose from the measured front of '{}', {} settings: {} ({}).", asked,
                     front.asked_at.empty() ? "" : ", " + front.asked_at + ",", front.subject,
                     front.points.size(), front.measured, front.knobs);
}

void add_front(Page& page, const DrawnFront& front) {
  if (front.chosen >= front.points.size()) {
    throw std::invalid_argument("add_front: the chosen point is none of the front");
  }
  page.add_paragraph(front_text(front));
  std::vector<std::string> charts{draw_error(front)};
  const bool has_meshes = std::any_of(front.points.begin(), front.points.end(),
                                      [](const FrontPoint& point) { return point.mesh > 0; });
  if (has_meshes) {
    charts.push_back(draw_front(front, "error of the meshes [mm]",
                                [](const FrontPoint& point) { return 1e3 * point.mesh; }));
  }
  page.add_charts(charts,
                  fmt::format("Error: {}.{} As measured then, not in this run.", front.error_name,
                              has_meshes ? " Beside it that of the meshes." : ""));
}

}  // namespace prehend::report
