#pragma once

#include <string>
#include <utility>
#include <vector>

namespace prehend::report {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;  // x, y; points with NaN are gaps
};

/// A vertical line across the chart with a label at its top.
struct Marker {
  double x = 0;
  std::string label;
};

struct LineChart {
  std::string title;
  std::string x_label;  // with unit, e.g. "time [s]"
  std::string y_label;
  std::vector<Series> series;
  std::vector<Marker> markers;
};

/// The chart as an SVG element, drawn by gnuplot.
/// @throws std::runtime_error when gnuplot is missing or refuses the data.
std::string draw_line_chart(const LineChart& chart);

}  // namespace prehend::report
