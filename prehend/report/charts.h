#pragma once

#include <string>
#include <utility>
#include <vector>

namespace prehend::report {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;  // x, y; points with NaN are gaps
  std::vector<double> deviations = {};            // one a point, drawn as +- bars; or empty
  bool connected = true;                          // by lines; else marks alone
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
  int width = 900;  // pixels, of which the letters have 11
};

/// One bar of each series beside the others for each category.
struct BarChart {
  struct Bars {
    std::string name;
    std::vector<double> values;           // one a category; NaN: no bar
    std::vector<double> deviations = {};  // one a category, drawn as +- bars; or empty
  };
  std::string title;
  std::string y_label;                  // with unit
  std::vector<std::string> categories;  // stand below their bars
  std::vector<Bars> series;
};

/// The chart as an SVG element, drawn by gnuplot.
/// @throws std::runtime_error when gnuplot is missing or refuses the data, or when a series has not
/// one value a category.
std::string draw_bar_chart(const BarChart& chart);

/// One bar a category, lying beside the category's name, the first on top; the series' values are
/// put end to end, and their sum is written behind. Deviations are not drawn; y_label is the axis
/// that lies. For few categories with long names. The same throws.
std::string draw_stacked_bars(const BarChart& chart);

/// The chart as an SVG element, drawn by gnuplot.
/// @throws std::runtime_error when gnuplot is missing or refuses the data.
std::string draw_line_chart(const LineChart& chart);

}  // namespace prehend::report
