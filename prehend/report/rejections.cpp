#include "prehend/report/rejections.h"

#include <algorithm>
#include <stdexcept>

#include "prehend/report/charts.h"

namespace prehend::report {
namespace {

std::size_t place_of(const std::string& name, std::vector<std::string>* names) {
  const auto found = std::find(names->begin(), names->end(), name);
  if (found != names->end()) return static_cast<std::size_t>(found - names->begin());
  names->push_back(name);
  return names->size() - 1;
}

BarChart bars_of(const std::vector<Rejected>& rejections, const std::string& what) {
  BarChart chart;
  chart.title = "Where " + what + " fell";
  chart.y_label = what;
  std::vector<std::string> groups;
  for (const Rejected& rejected : rejections) {
    place_of(rejected.reason, &chart.categories);
    place_of(rejected.group, &groups);
  }
  for (const std::string& group : groups) {
    chart.series.push_back({group, std::vector<double>(chart.categories.size(), 0), {}});
  }
  for (const Rejected& rejected : rejections) {
    chart.series[place_of(rejected.group, &groups)]
        .values[place_of(rejected.reason, &chart.categories)] += rejected.count;
  }
  return chart;
}

}  // namespace

void add_rejections(Page& page, const std::vector<Rejected>& rejections, int candidates,
                    const std::string& what) {
  if (rejections.empty()) return;
  int fallen = 0;
  std::vector<std::vector<std::string>> rows;
  for (const Rejected& rejected : rejections) {
    fallen += rejected.count;
    rows.push_back({std::to_string(rejected.count), rejected.reason, rejected.group,
                    rejected.nearest_miss.empty() ? "-" : rejected.nearest_miss});
  }
  try {
    page.add_chart(
        draw_stacked_bars(bars_of(rejections, what)),
        std::to_string(fallen) + " of " + std::to_string(candidates) + " " + what + " fell.");
  } catch (const std::runtime_error& error) {
    page.add_paragraph(std::string("The bars could not be drawn: ") + error.what());
  }
  page.add_table({what, "fell at", "of", "nearest miss"}, rows);
}

}  // namespace prehend::report
