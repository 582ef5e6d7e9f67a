#include "eval/mesh_deviation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/deviation_summary.h"
#include "eval/text_files.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/text/json.h"

namespace prehend::eval {
namespace {

std::string data_set_of(const CaseResult& r) { return r.data_set; }
std::string orientation_of(const CaseResult& r) { return std::to_string(r.orientation); }
double centroid_of(const MethodResult& m) { return m.centroid_error; }
double vote_of(const MethodResult& m) { return m.vote; }

std::vector<std::string> groups_of(const std::vector<CaseResult>& results) {
  std::vector<std::string> groups;
  for (const CaseResult& r : results) {
    if (std::find(groups.begin(), groups.end(), r.group) == groups.end()) groups.push_back(r.group);
  }
  return groups;
}

std::vector<CaseResult> of_group(const std::vector<CaseResult>& results, const std::string& group) {
  std::vector<CaseResult> selected;
  std::copy_if(results.begin(), results.end(), std::back_inserter(selected),
               [&](const CaseResult& r) { return r.group == group; });
  return selected;
}

int failures_of(const std::vector<CaseResult>& results, const std::string& method) {
  const Spread spread = total(results, method, deviation_of);
  return static_cast<int>(results.size()) - spread.count;
}

bool any_known(const SummaryTable& table) {
  for (const auto& row : table.cells) {
    for (const Spread& s : row) {
      if (s.count > 0) return true;
    }
  }
  return false;
}

// What one of the paper's figures shows and what it is called.
struct Figure {
  const char* name;
  const char* title;
  const char* unit;
  double scale;
  FigureOf figure_of;
  bool by_orientation;
};

const std::vector<Figure>& figures() {
  static const std::vector<Figure> list = {
      {"deviation_by_orientation", "Deviation of the mesh from the truth", "mm", 1000, deviation_of,
       true},
      {"deviation_by_object", "Deviation of the mesh from the truth", "mm", 1000, deviation_of,
       false},
      {"centroid_by_orientation", "Error of the centroid", "% of the diagonal", 100, centroid_of,
       true},
      {"centroid_by_object", "Error of the centroid", "% of the diagonal", 100, centroid_of, false},
      {"vote_by_orientation", "Vote of the chosen plane (smaller is better)", "1", 1, vote_of,
       true}};
  return list;
}

std::string chart_of(const Figure& figure, const SummaryTable& table) {
  const std::string y_label = fmt::format("mean +- deviation [{}]", figure.unit);
  if (figure.by_orientation) {
    report::LineChart chart{figure.title, "orientation [deg]", y_label, {}, {}};
    for (std::size_t m = 0; m < table.methods.size(); ++m) {
      report::Series series;
      series.name = table.methods[m];
      for (std::size_t r = 0; r < table.rows.size(); ++r) {
        const Spread& s = table.cells[r][m];
        if (s.count == 0) continue;
        // A little beside each other, so that the bars can be told apart.
        const double shift = 1.5 * (static_cast<double>(m) - 0.5 * table.methods.size());
        series.points.emplace_back(std::stod(table.rows[r]) + shift, figure.scale * s.mean);
        series.deviations.push_back(figure.scale * s.deviation);
      }
      if (!series.points.empty()) chart.series.push_back(std::move(series));
    }
    return report::draw_line_chart(chart);
  }
  report::BarChart chart{figure.title, y_label, table.rows, {}};
  for (std::size_t m = 0; m < table.methods.size(); ++m) {
    report::BarChart::Bars bars;
    bars.name = table.methods[m];
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      bars.values.push_back(figure.scale * table.cells[r][m].mean);
      bars.deviations.push_back(figure.scale * table.cells[r][m].deviation);
    }
    chart.series.push_back(std::move(bars));
  }
  return report::draw_bar_chart(chart);
}

std::vector<std::string> totals_header(const ShapeComparison& comparison) {
  std::vector<std::string> header = {"method"};
  for (const MethodColumn& column : comparison.columns) header.push_back(column.title);
  header.push_back("without a mesh");
  return header;
}

std::string text_of(const Spread& s, const MethodColumn& column) {
  if (s.count == 0) return "-";
  if (!column.with_spread) return fmt::format("{:.1f}", column.scale * s.mean);
  return fmt::format("{:.2f} +- {:.2f}", column.scale * s.mean, column.scale * s.deviation);
}

std::vector<std::vector<std::string>> totals(const std::vector<CaseResult>& results,
                                             const std::vector<Method>& methods,
                                             const ShapeComparison& comparison) {
  std::vector<std::vector<std::string>> rows;
  for (const Method& method : methods) {
    std::vector<std::string> row = {method.name};
    for (const MethodColumn& column : comparison.columns) {
      row.push_back(text_of(total(results, method.name, column.figure_of), column));
    }
    row.push_back(fmt::format("{} of {}", failures_of(results, method.name), results.size()));
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::vector<std::string>> goal_rows(const std::vector<Goal>& goals) {
  std::vector<std::vector<std::string>> rows;
  for (const Goal& goal : goals) {
    rows.push_back({goal.name, goal.bar, goal.measured, to_string(goal.outcome)});
  }
  return rows;
}

const std::vector<std::string> kGoalHeader = {"goal", "bar", "measured", ""};

void add_problems(report::Page& page, const std::vector<CaseResult>& results) {
  std::vector<std::vector<std::string>> rows;
  for (const CaseResult& result : results) {
    if (!result.problem.empty()) rows.push_back({result.case_name, "", result.problem});
    for (const MethodResult& method : result.methods) {
      if (!method.problem.empty())
        rows.push_back({result.case_name, method.method, method.problem});
    }
  }
  if (rows.empty()) return;
  page.add_heading("What gave no mesh, and why");
  page.add_table({"case", "method", "why"}, rows);
}

// Rows of equal width for the terminal.
std::string aligned(const std::vector<std::string>& header,
                    const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < header.size(); ++c) {
    widths.push_back(header[c].size());
    for (const auto& row : rows) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      text += fmt::format("  {:<{}}", row[c], c + 1 < row.size() ? widths[c] : 0);
    }
    text += '\n';
  };
  add(header);
  for (const auto& row : rows) add(row);
  return text;
}

}  // namespace

void write_mesh_deviation_report(const std::filesystem::path& folder,
                                 const std::vector<CaseResult>& results,
                                 const std::vector<Method>& methods,
                                 const ShapeComparison& comparison) {
  report::Page page("Mesh deviation");
  page.add_paragraph(
      "Stereo pairs of known bodies, rendered with texture and noise, go through semi-global "
      "matching, segmentation, completion and meshing. The deviation is the mean distance of "
      "points spread evenly over the true surface to the mesh, the truth's pose being known.");
  for (const Method& method : methods) {
    page.add_paragraph(method.name + ": " + method.description);
  }
  for (const std::string& group : groups_of(results)) {
    const std::vector<CaseResult> of = of_group(results, group);
    page.add_heading("Objects: " + group);
    const std::vector<Goal> goals = comparison.judge(of);
    const auto count = [&](Goal::Outcome outcome) {
      return std::count_if(goals.begin(), goals.end(),
                           [&](const Goal& g) { return g.outcome == outcome; });
    };
    const auto missed = count(Goal::Outcome::kMissed);
    page.add_verdict(fmt::format("{} goals are met, {} missed", count(Goal::Outcome::kMet), missed),
                     missed == 0);
    page.add_table(kGoalHeader, goal_rows(goals));
    page.add_table(totals_header(comparison), totals(of, methods, comparison));
    for (const Figure& figure : figures()) {
      const SummaryTable table = summarize(
          of, figure.by_orientation ? RowOf(orientation_of) : RowOf(data_set_of), figure.figure_of);
      if (!any_known(table)) continue;
      const std::string name = group + "_" + figure.name;
      const std::string row_name = figure.by_orientation ? "orientation [deg]" : "data set";
      write_text(folder / (name + ".csv"), to_csv(table, row_name, figure.scale));
      const std::string svg = chart_of(figure, table);
      write_text(folder / (name + ".svg"), svg);
      page.add_chart(svg, name + ".csv, .svg");
    }
  }
  add_problems(page, results);
  write_text(folder / "cases.csv", cases_csv(results));
  page.write(folder / "index.html");
}

std::string mesh_deviation_json(const std::vector<CaseResult>& results,
                                const std::vector<Method>& methods,
                                const ShapeComparison& comparison) {
  text::Json groups = text::Json::array();
  for (const std::string& group : groups_of(results)) {
    const std::vector<CaseResult> of = of_group(results, group);
    text::Json goals = text::Json::array();
    for (const Goal& goal : comparison.judge(of)) {
      goals.add(text::Json::object()
                    .set("name", goal.name)
                    .set("bar", goal.bar)
                    .set("measured", goal.measured)
                    .set("met", to_string(goal.outcome)));
    }
    text::Json of_methods = text::Json::array();
    for (const Method& method : methods) {
      text::Json of_method = text::Json::object().set("name", method.name);
      for (const MethodColumn& column : comparison.columns) {
        of_method.set(column.key, total(of, method.name, column.figure_of).mean);
      }
      of_methods.add(
          of_method.set("standard_deviation_m", total(of, method.name, deviation_of).deviation)
              .set("without_mesh", failures_of(of, method.name)));
    }
    groups.add(text::Json::object()
                   .set("name", group)
                   .set("cases", of.size())
                   .set("goals", goals)
                   .set("methods", of_methods));
  }
  return text::Json::object().set("groups", groups).pretty();
}

std::string mesh_deviation_text(const std::vector<CaseResult>& results,
                                const std::vector<Method>& methods,
                                const ShapeComparison& comparison) {
  std::string text;
  for (const std::string& group : groups_of(results)) {
    const std::vector<CaseResult> of = of_group(results, group);
    text += fmt::format("\n{} ({} cases)\n{}\n{}", group, of.size(),
                        aligned(totals_header(comparison), totals(of, methods, comparison)),
                        aligned(kGoalHeader, goal_rows(comparison.judge(of))));
  }
  return text;
}

}  // namespace prehend::eval
