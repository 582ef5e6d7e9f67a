#include "prehend/report/charts.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "prehend/report/drawing_program.h"

namespace prehend::report {
namespace {

// In gnuplot's single-quoted strings only the quote itself is special.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\n') continue;
    out += c;
    if (c == '\'') out += c;
  }
  return out + "'";
}

void write_head(const std::string& title, std::ostream& out, int height = 360, int width = 900) {
  out << "set terminal svg size " << width << ',' << height
      << " dynamic noenhanced font 'DejaVu Sans,11' background "
         "'#ffffff'\n"
      << "set output 'chart.svg'\n"
      << "set title " << quoted(title) << "\nset grid\nset key outside right top\n"
      << "set datafile missing 'nan'\nset tmargin 4\n";
}

void write_line_script(const LineChart& chart, const std::filesystem::path& folder,
                       std::ostream& out) {
  constexpr int kHeight = 360;  // pixels
  write_head(chart.title, out, kHeight, chart.width);
  out << "set xlabel " << quoted(chart.x_label) << "\nset ylabel " << quoted(chart.y_label) << '\n';
  int tag = 1;
  for (const auto& marker : chart.markers) {
    out << "set arrow " << tag << " from " << marker.x << ", graph 0 to " << marker.x
        << ", graph 1 nohead dashtype 2 lc rgb '#888888'\n"
        << "set label " << tag << ' ' << quoted(marker.label) << " at " << marker.x
        << ", graph 1.03 rotate by 0 font ',9' tc rgb '#555555'\n";
    ++tag;
  }
  out << "plot ";
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& series = chart.series[i];
    const std::string file = "series" + std::to_string(i) + ".txt";
    std::ofstream data(folder / file);
    data.precision(9);
    const bool bars = !series.deviations.empty();
    for (std::size_t k = 0; k < series.points.size(); ++k) {
      data << series.points[k].first << ' ' << series.points[k].second;
      if (bars) data << ' ' << series.deviations.at(k);
      data << '\n';
    }
    if (!data) throw std::runtime_error("cannot write a chart's data");
    const char* style = bars ? (series.connected ? "with yerrorlines lw 1.5" : "with yerrorbars")
                             : (series.connected ? "with lines lw 1.5" : "with points pt 7 ps 0.5");
    out << (i == 0 ? "" : ", ") << quoted(file) << " using " << (bars ? "1:2:3 " : "1:2 ") << style
        << " title " << quoted(series.name);
  }
  out << '\n';
}

void write_bar_script(const BarChart& chart, const std::filesystem::path& folder,
                      std::ostream& out) {
  write_head(chart.title, out);
  bool bars = false;
  for (const auto& series : chart.series) bars = bars || !series.deviations.empty();
  out << "set ylabel "
      << quoted(chart.y_label)
      // From 0 up, or down.
      << "\nset yrange [*<0:0<*]\nset xzeroaxis lt -1\nset style data histograms\n"
      << "set style histogram " << (bars ? "errorbars gap 1.5 lw 1" : "clustered gap 1.5")
      << "\nset style fill solid 0.8\nset xtics rotate by -40 font ',9'\nset bmargin 7\n";
  std::ofstream data(folder / "bars.txt");
  data.precision(9);
  for (std::size_t k = 0; k < chart.categories.size(); ++k) {
    data << '"';
    for (const char c : chart.categories[k]) data << (c == '"' || c == '\n' ? ' ' : c);
    data << '"';
    for (const auto& series : chart.series) {
      data << ' ' << series.values.at(k);
      if (bars) data << ' ' << (series.deviations.empty() ? 0 : series.deviations.at(k));
    }
    data << '\n';
  }
  if (!data) throw std::runtime_error("cannot write a chart's data");
  out << "plot ";
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const std::size_t column = 2 + (bars ? 2 : 1) * i;
    out << (i == 0 ? "" : ", ") << "'bars.txt' using " << column;
    if (bars) out << ':' << column + 1;
    out << ":xtic(1) title " << quoted(chart.series[i].name);
  }
  out << '\n';
}

void write_stacked_script(const BarChart& chart, const std::filesystem::path& folder,
                          std::ostream& out) {
  constexpr int kFrame = 130, kBar = 28;  // pixels: title and axis, one bar
  constexpr double kHalf = 0.38;          // of the distance between two bars
  const std::size_t count = chart.categories.size();
  write_head(chart.title, out, kFrame + kBar * static_cast<int>(count));
  out << "set xlabel " << quoted(chart.y_label)
      << "\nset xrange [0:*]\nset offsets 0,graph 0.08,0,0\n"
      << "set yrange [" << static_cast<double>(count) - 0.5
      << ":-0.5]\nunset grid\nset grid xtics\n"
      << "set style fill solid 0.8\nset ytics (";
  for (std::size_t k = 0; k < count; ++k) {
    out << (k == 0 ? "" : ", ") << quoted(chart.categories[k]) << ' ' << k;
  }
  out << ") scale 0\nplot ";
  std::vector<double> ends(count, 0);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const std::string file = "series" + std::to_string(i) + ".txt";
    std::ofstream data(folder / file);
    data.precision(9);
    for (std::size_t k = 0; k < count; ++k) {
      const double value = chart.series[i].values[k], begin = ends[k];
      if (!(value > 0)) continue;
      ends[k] += value;
      const auto at = static_cast<double>(k);
      data << begin + value / 2 << ' ' << k << ' ' << begin << ' ' << ends[k] << ' ' << at - kHalf
           << ' ' << at + kHalf << '\n';
    }
    if (!data) throw std::runtime_error("cannot write a chart's data");
    out << quoted(file) << " with boxxyerror "
        << (chart.series[i].name.empty() ? "notitle" : "title " + quoted(chart.series[i].name))
        << ", ";
  }
  std::ofstream sums(folder / "sums.txt");
  sums.precision(9);
  for (std::size_t k = 0; k < count; ++k) sums << ends[k] << ' ' << k << ' ' << ends[k] << '\n';
  if (!sums) throw std::runtime_error("cannot write a chart's data");
  out << "'sums.txt' using 1:2:3 with labels left offset 0.5,0 notitle\n";
}

template <typename Write>
std::string draw(const std::string& title, const Write& write) {
  return drawn_by({"gnuplot", "gnuplot script", "gnuplot-nox"}, title, write);
}

void check_bars(const BarChart& chart) {
  bool any = false;
  for (const auto& series : chart.series) {
    if (series.values.size() != chart.categories.size()) {
      throw std::runtime_error("the chart '" + chart.title + "' has " +
                               std::to_string(chart.categories.size()) + " categories but '" +
                               series.name + "' has " + std::to_string(series.values.size()) +
                               " values");
    }
    for (const double value : series.values) any = any || std::isfinite(value);
  }
  if (!any) throw std::runtime_error("the chart '" + chart.title + "' has no finite value");
}

}  // namespace

std::string draw_line_chart(const LineChart& chart) {
  bool any = false;
  for (const auto& series : chart.series) {
    for (const auto& [x, y] : series.points) any = any || (std::isfinite(x) && std::isfinite(y));
  }
  if (!any) throw std::runtime_error("the chart '" + chart.title + "' has no finite point");
  return draw(chart.title, [&](const std::filesystem::path& folder, std::ostream& script) {
    write_line_script(chart, folder, script);
  });
}

std::string draw_bar_chart(const BarChart& chart) {
  check_bars(chart);
  return draw(chart.title, [&](const std::filesystem::path& folder, std::ostream& script) {
    write_bar_script(chart, folder, script);
  });
}

std::string draw_stacked_bars(const BarChart& chart) {
  check_bars(chart);
  return draw(chart.title, [&](const std::filesystem::path& folder, std::ostream& script) {
    write_stacked_script(chart, folder, script);
  });
}

}  // namespace prehend::report
