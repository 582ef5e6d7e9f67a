#include "eval/belief/belief_report.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/deviation_summary.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/text/json.h"

namespace prehend::eval {
namespace {

constexpr double kWorse = 3e-4;  // m

const std::vector<std::string> kHeader{"group",       "touches told", "touches",      "views",
                                       "unseen [mm]", "change [%]",   "Chamfer [mm]", "Jaccard",
                                       "worse [%]",   "update [ms]"};

std::vector<std::string> groups_of(const std::vector<BeliefCase>& cases) {
  std::vector<std::string> groups;
  for (const BeliefCase& one : cases) {
    if (std::find(groups.begin(), groups.end(), one.group) == groups.end()) {
      groups.push_back(one.group);
    }
  }
  if (groups.size() > 1) groups.push_back("all");
  return groups;
}

/// The series of that name of all views of the group that have a step in it.
std::vector<const BeliefSeries*> selected(const std::vector<BeliefCase>& cases,
                                          const std::string& group, const std::string& name) {
  std::vector<const BeliefSeries*> found;
  for (const BeliefCase& one : cases) {
    if (group != "all" && one.group != group) continue;
    for (const BeliefSeries& series : one.series) {
      if (series.name == name && !series.steps.empty()) found.push_back(&series);
    }
  }
  return found;
}

BeliefTotals totals_of(const std::string& group, const std::string& name,
                       const std::vector<const BeliefSeries*>& all, double prediction) {
  BeliefTotals totals{group, name, static_cast<int>(all.size()), {}};
  std::size_t most = 0;
  for (const BeliefSeries* series : all) most = std::max(most, series->steps.size());
  for (std::size_t t = 0; t < most; ++t) {
    std::vector<double> unseen, chamfer, jaccard, seconds;
    int worse = 0, touched = 0;
    for (const BeliefSeries* series : all) {
      const BeliefStep& step = series->steps[std::min(t, series->steps.size() - 1)];
      unseen.push_back(step.unseen);
      chamfer.push_back(step.chamfer);
      jaccard.push_back(step.jaccard);
      seconds.push_back(step.seconds);
      if (t == 0 || t >= series->steps.size()) continue;
      ++touched;
      if (step.unseen > series->steps[t - 1].unseen + kWorse) ++worse;
    }
    const double mean = spread_of(unseen).mean;
    totals.touched.push_back({mean, spread_of(chamfer).mean, spread_of(jaccard).mean,
                              touched > 0 ? static_cast<double>(worse) / touched : kUnknown,
                              spread_of(seconds).mean, mean / prediction - 1});
  }
  return totals;
}

std::string cell(double value, const char* format) {
  return std::isnan(value) ? "" : fmt::format(fmt::runtime(format), value);
}

std::vector<std::vector<std::string>> rows_of(const std::vector<BeliefCase>& cases) {
  std::vector<std::vector<std::string>> rows;
  for (const BeliefTotals& totals : belief_totals(cases)) {
    for (std::size_t t = 0; t < totals.touched.size(); ++t) {
      const BeliefTotals::Touched& at = totals.touched[t];
      rows.push_back({totals.group, totals.series, std::to_string(t), std::to_string(totals.views),
                      cell(1e3 * at.unseen, "{:.2f}"), cell(100 * at.change, "{:+.0f}"),
                      cell(1e3 * at.chamfer, "{:.2f}"), cell(at.jaccard, "{:.3f}"),
                      cell(100 * at.worse, "{:.1f}"), cell(1e3 * at.seconds, "{:.1f}")});
    }
  }
  return rows;
}

}  // namespace

std::vector<BeliefTotals> belief_totals(const std::vector<BeliefCase>& cases) {
  std::vector<std::string> names;
  for (const BeliefCase& one : cases) {
    for (const BeliefSeries& series : one.series) {
      if (std::find(names.begin(), names.end(), series.name) == names.end()) {
        names.push_back(series.name);
      }
    }
  }
  std::vector<BeliefTotals> totals;
  for (const std::string& group : groups_of(cases)) {
    const auto predicted = selected(cases, group, kPredictionSeries);
    const double prediction = totals_of(group, "", predicted, 1).touched.empty()
                                  ? kUnknown
                                  : totals_of(group, "", predicted, 1).touched.front().unseen;
    for (const std::string& name : names) {
      totals.push_back(totals_of(group, name, selected(cases, group, name), prediction));
    }
  }
  return totals;
}

std::string belief_text(const std::vector<BeliefCase>& cases) {
  std::string text;
  for (const BeliefCase& one : cases) {
    if (!one.problem.empty()) text += one.case_name + ": " + one.problem + "\n";
  }
  std::vector<std::vector<std::string>> rows = rows_of(cases);
  rows.insert(rows.begin(), kHeader);
  std::vector<std::size_t> widths(kHeader.size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) text += fmt::format("{:<{}}  ", row[i], widths[i]);
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

std::string belief_json(const std::vector<BeliefCase>& cases) {
  text::Json all = text::Json::array();
  for (const BeliefTotals& totals : belief_totals(cases)) {
    for (std::size_t t = 0; t < totals.touched.size(); ++t) {
      const BeliefTotals::Touched& at = totals.touched[t];
      all.add(text::Json::object()
                  .set("group", totals.group)
                  .set("told", totals.series)
                  .set("touches", t)
                  .set("views", totals.views)
                  .set("unseen_m", at.unseen)
                  .set("change", at.change)
                  .set("chamfer_m", at.chamfer)
                  .set("jaccard", at.jaccard)
                  .set("worse", at.worse)
                  .set("update_s", at.seconds));
    }
  }
  return text::Json::object().set("totals", all).pretty();
}

void write_belief_report(const std::filesystem::path& folder,
                         const std::vector<BeliefCase>& cases) {
  report::Page page("What touches make of a predicted shape");
  page.add_paragraph(
      "Each object is seen once, by a rendered stereo pair, and predicted. A fingertip then "
      "touches "
      "it where that tells most, and what it feels and goes through corrects the prediction. The "
      "unseen error is the mean distance of the true surface that the camera did not see, but for "
      "what lies on the table, to the believed one. The change is beside the prediction alone; "
      "worse are touches after which the unseen error is more than 0.3 mm larger.");
  for (const std::string& group : groups_of(cases)) {
    report::LineChart chart;
    chart.title = group;
    chart.x_label = "touches";
    chart.y_label = "unseen error [mm]";
    for (const BeliefTotals& totals : belief_totals(cases)) {
      if (totals.group != group) continue;
      report::Series series{totals.series, {}};
      for (std::size_t t = 0; t < totals.touched.size(); ++t) {
        series.points.emplace_back(t, 1e3 * totals.touched[t].unseen);
      }
      chart.series.push_back(series);
    }
    page.add_chart(report::draw_line_chart(chart), "Group " + group);
  }
  page.add_table(kHeader, rows_of(cases));
  page.add_heading("Views");
  std::vector<std::vector<std::string>> views;
  for (const BeliefCase& one : cases) {
    for (const BeliefSeries& series : one.series) {
      std::string errors;
      for (const BeliefStep& step : series.steps) {
        errors += (errors.empty() ? "" : ", ") + cell(1e3 * step.unseen, "{:.2f}");
      }
      views.push_back({one.case_name, series.name, errors, series.problem});
    }
    if (!one.problem.empty()) views.push_back({one.case_name, "", "", one.problem});
  }
  page.add_table({"view", "touches told", "unseen error by touches [mm]", "remark"}, views);
  page.write(folder / "index.html");
}

}  // namespace prehend::eval
