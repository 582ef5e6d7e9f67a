#include "eval/touch/tradeoff_page.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "eval/text_files.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"

namespace prehend::eval::touch {
namespace {

namespace fs = std::filesystem;

// All settings and the front of one table, on axes of powers of ten.
std::string draw(const std::string& title, const std::vector<MeasuredTouch>& all,
                 const fidelity::Front& front) {
  report::LineChart chart{title,
                          "log10 of processor time [ms] for a simulated second",
                          "log10 of the images' error [% of the largest sum]",
                          {},
                          {}};
  report::Series tried{"settings", {}, {}, false}, best{"front", {}, {}, true};
  const auto point = [](double seconds, double error) {
    // Errors below a millionth are rounding.
    return std::pair(std::log10(1e3 * seconds), std::log10(100 * std::max(error, 1e-6)));
  };
  for (const MeasuredTouch& m : all) {
    if (m.feels) tried.points.push_back(point(m.setting.seconds, m.error.image));
  }
  for (const fidelity::Setting& s : front.settings) {
    best.points.push_back(point(s.seconds, s.error));
  }
  chart.series = {tried, best};
  return report::draw_line_chart(chart);
}

// What was measured of one setting, for table and file.
std::vector<std::string> row_of(const MeasuredTouch& m) {
  const auto percent = [&](double share) {
    return m.feels ? fmt::format("{:.3g}", 100 * share) : std::string("-");
  };
  const auto micrometres = [](double metres) { return fmt::format("{:.3g}", 1e6 * metres); };
  std::vector<std::string> row{fmt::format("{:.3g}", 1e3 * m.setting.seconds),
                               percent(m.error.image), percent(m.error.sum),
                               percent(m.error.largest), micrometres(m.error.motion)};
  row.push_back(m.own ? percent(m.own->image) : "-");
  row.push_back(m.own ? micrometres(m.own->motion) : "-");
  row.push_back(to_string(m.setting));
  return row;
}

void add_table(const fs::path& out, const std::string& name, const std::string& title,
               const std::vector<MeasuredTouch>& all, report::Page& page) {
  std::string csv =
      "milliseconds_per_second,image_percent,sum_percent,largest_percent,motion_um,"
      "own_image_percent,own_motion_um,knobs\n";
  std::vector<std::vector<std::string>> rows;
  for (const MeasuredTouch& m : all) {
    rows.push_back(row_of(m));
    for (std::size_t i = 0; i + 1 < rows.back().size(); ++i) csv += rows.back()[i] + ",";
    csv += "\"" + rows.back().back() + "\"\n";
  }
  write_text(out / (name + ".csv"), csv);
  page.add_heading(title);
  page.add_table({"time [ms/s]", "image [%]", "sum [%]", "largest [%]", "motion [um]",
                  "own image [%]", "own motion [um]", "setting"},
                 rows);
}

void add_touch(const fs::path& out, const std::string& title, const std::vector<MeasuredTouch>& all,
               const fidelity::Front& front, const fs::path& fronts, report::Page& page) {
  fidelity::write_front(fronts / (front.subject + ".yaml"), front);
  const std::string svg = draw(title, all, front);
  write_text(out / (front.subject + ".svg"), svg);
  add_table(out, front.subject, title, all, page);
  page.add_paragraph("Error: " + front.error_name + ".");
  page.add_chart(svg, "Every setting that was tried, and those that nothing beats");
}

}  // namespace

void write_touch_tradeoff(const TouchTradeoff& tradeoff, const std::string& machine,
                          const fs::path& fronts, const fs::path& out) {
  report::Page page("Speed against accuracy of soft contact");
  page.add_paragraph("Measured on: " + machine +
                     ". Images, sums: root mean squares over a run of the difference from a finer "
                     "one's, in parts of the largest sum of a pad; motion: of the object.");
  add_touch(out, "Work cycles of the PG70", tradeoff.cycle, cycle_front(tradeoff, machine), fronts,
            page);
  add_table(out, "touch_texels", "The same with other texels on pads of that size", tradeoff.texels,
            page);
  add_touch(out, "Work cycles of the SDH-2", tradeoff.hand, hand_front(tradeoff, machine), fronts,
            page);
  add_touch(out, "Engines: a held, shaken cube", tradeoff.engines, engine_front(tradeoff, machine),
            fronts, page);
  for (const std::string& reason : tradeoff.left_out) page.add_paragraph("Left out: " + reason);
  page.write(out / "index.html");
}

}  // namespace prehend::eval::touch
