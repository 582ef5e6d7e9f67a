#include "prehend/report/charts.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <unistd.h>

namespace prehend::report {
namespace {

// A private folder that goes with its owner.
struct TemporaryFolder {
  std::filesystem::path path;
  TemporaryFolder() {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-chart-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) {
      throw std::runtime_error("cannot make a temporary folder for a chart");
    }
    path = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;  // a left-over in /tmp is no reason to fail
    std::filesystem::remove_all(path, ignored);
  }
};

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

void write_script(const LineChart& chart, const std::filesystem::path& folder, std::ostream& out) {
  out << "set terminal svg size 900,360 dynamic noenhanced font 'DejaVu Sans,11' background "
         "'#ffffff'\n"
      << "set output 'chart.svg'\n"
      << "set title " << quoted(chart.title) << "\nset xlabel " << quoted(chart.x_label)
      << "\nset ylabel " << quoted(chart.y_label) << "\nset grid\nset key outside right top\n"
      << "set datafile missing 'nan'\nset tmargin 4\n";
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
    const std::string file = "series" + std::to_string(i) + ".txt";
    std::ofstream data(folder / file);
    data.precision(9);
    for (const auto& [x, y] : chart.series[i].points) data << x << ' ' << y << '\n';
    if (!data) throw std::runtime_error("cannot write a chart's data");
    out << (i == 0 ? "" : ", ") << quoted(file) << " using 1:2 with lines lw 1.5 title "
        << quoted(chart.series[i].name);
  }
  out << '\n';
}

}  // namespace

std::string draw_line_chart(const LineChart& chart) {
  bool any = false;
  for (const auto& series : chart.series) {
    for (const auto& [x, y] : series.points) any = any || (std::isfinite(x) && std::isfinite(y));
  }
  if (!any) throw std::runtime_error("the chart '" + chart.title + "' has no finite point");

  const TemporaryFolder folder;
  {
    std::ofstream script(folder.path / "script");
    write_script(chart, folder.path, script);
  }
  const std::string command =
      "cd " + quoted(folder.path.string()) + " && gnuplot script >errors 2>&1 </dev/null";
  const int status = std::system(command.c_str());
  std::ifstream svg(folder.path / "chart.svg");
  std::stringstream text;
  text << svg.rdbuf();
  if (status != 0 || text.str().find("</svg>") == std::string::npos) {
    std::ifstream errors(folder.path / "errors");
    std::stringstream reason;
    reason << errors.rdbuf();
    throw std::runtime_error("gnuplot could not draw '" + chart.title + "': " + reason.str() +
                             "(is the package gnuplot-nox installed?)");
  }
  // Without the XML prologue, so that it can stand inside a page.
  return text.str().substr(text.str().find("<svg"));
}

}  // namespace prehend::report
