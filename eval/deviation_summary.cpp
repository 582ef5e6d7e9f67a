#include "eval/deviation_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace prehend::eval {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kSureConfidence = 0.9;
constexpr double kSureDeviation = 5 * kMillimetre;

const MethodResult* method_of(const CaseResult& result, const std::string& name) {
  for (const MethodResult& method : result.methods) {
    if (method.method == name) return &method;
  }
  return nullptr;
}

std::string cell(double value, double scale) {
  return std::isnan(value) ? "" : fmt::format("{:.4f}", scale * value);
}

// A field of a CSV file.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += c;
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

std::size_t column_of(const SummaryTable& table, const std::string& method) {
  return static_cast<std::size_t>(std::find(table.methods.begin(), table.methods.end(), method) -
                                  table.methods.begin());
}

Goal::Outcome outcome_of(bool met) { return met ? Goal::Outcome::kMet : Goal::Outcome::kMissed; }

Goal at_most(const std::string& name, double bar, double measured, double scale,
             const std::string& unit) {
  Goal goal;
  goal.name = name;
  goal.bar = fmt::format("<= {:g} {}", bar * scale, unit);
  if (std::isnan(measured)) return goal;
  goal.measured = fmt::format("{:.2f} {}", measured * scale, unit);
  goal.outcome = outcome_of(measured <= bar);
  return goal;
}

// The largest excess of the first method's mean over the second's in any row.
Goal never_worse(const std::string& name, const SummaryTable& table, const std::string& first,
                 const std::string& second, double allowed) {
  Goal goal;
  goal.name = name;
  goal.bar = fmt::format("excess <= {:g} mm", allowed / kMillimetre);
  const std::size_t a = column_of(table, first), b = column_of(table, second);
  if (a == table.methods.size() || b == table.methods.size()) return goal;
  double worst = -std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    // A method that failed on a whole row is no rival there.
    if (table.cells[r][b].count == 0) continue;
    if (table.cells[r][a].count == 0) {
      goal.measured = "no result on " + table.rows[r];
      goal.outcome = Goal::Outcome::kMissed;
      return goal;
    }
    const double excess = table.cells[r][a].mean - table.cells[r][b].mean;
    if (excess <= worst) continue;
    worst = excess;
    goal.measured = fmt::format("{:+.2f} mm on {}", excess / kMillimetre, table.rows[r]);
    goal.outcome = outcome_of(excess <= allowed);
  }
  return goal;
}

Goal calibrated(const std::vector<CaseResult>& results) {
  int sure = 0, right = 0, known = 0;
  for (const CaseResult& result : results) {
    const MethodResult* ours = method_of(result, "Ours");
    if (ours == nullptr || std::isnan(ours->confidence)) continue;
    ++known;
    if (ours->confidence < kSureConfidence) continue;
    ++sure;
    right += is_right(*ours);
  }
  Goal goal;
  goal.name = "of the results called >= 90 % sure within 5 mm, share that is";
  goal.bar = ">= 85 %";
  if (known == 0) return goal;
  if (sure == 0) {
    goal.measured = fmt::format("none of {} results is called so sure", known);
    return goal;
  }
  goal.measured =
      fmt::format("{:.1f} % ({} of {}; {} results)", 100.0 * right / sure, right, sure, known);
  goal.outcome = outcome_of(right >= 0.85 * sure);
  return goal;
}

}  // namespace

bool is_right(const MethodResult& result) {
  return result.mean <= kSureDeviation && result.back_mean <= kSureDeviation;
}

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  double sum = 0;
  for (const double v : values) {
    if (std::isnan(v)) continue;
    sum += v;
    ++spread.count;
  }
  if (spread.count == 0) return spread;
  spread.mean = sum / spread.count;
  double squares = 0;
  for (const double v : values) {
    if (!std::isnan(v)) squares += (v - spread.mean) * (v - spread.mean);
  }
  spread.deviation = std::sqrt(squares / spread.count);
  return spread;
}

SummaryTable summarize(const std::vector<CaseResult>& results, const RowOf& row_of,
                       const FigureOf& figure_of) {
  SummaryTable table;
  for (const CaseResult& result : results) {
    const std::string row = row_of(result);
    if (std::find(table.rows.begin(), table.rows.end(), row) == table.rows.end()) {
      table.rows.push_back(row);
    }
    for (const MethodResult& method : result.methods) {
      if (column_of(table, method.method) == table.methods.size()) {
        table.methods.push_back(method.method);
      }
    }
  }
  for (const std::string& row : table.rows) {
    std::vector<Spread> cells;
    for (const std::string& name : table.methods) {
      std::vector<double> values;
      for (const CaseResult& result : results) {
        const MethodResult* method = method_of(result, name);
        if (method != nullptr && row_of(result) == row) values.push_back(figure_of(*method));
      }
      cells.push_back(spread_of(values));
    }
    table.cells.push_back(std::move(cells));
  }
  return table;
}

Spread total(const std::vector<CaseResult>& results, const std::string& method,
             const FigureOf& figure_of) {
  std::vector<double> values;
  for (const CaseResult& result : results) {
    if (const MethodResult* found = method_of(result, method)) values.push_back(figure_of(*found));
  }
  return spread_of(values);
}

std::string to_csv(const SummaryTable& table, const std::string& row_name, double scale) {
  std::string text = row_name;
  for (const std::string& method : table.methods) {
    text += fmt::format(",{0} mean,{0} deviation,{0} count", method);
  }
  text += '\n';
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    text += table.rows[r];
    for (const Spread& spread : table.cells[r]) {
      text += fmt::format(",{},{},{}", cell(spread.mean, scale), cell(spread.deviation, scale),
                          spread.count);
    }
    text += '\n';
  }
  return text;
}

std::string cases_csv(const std::vector<CaseResult>& results) {
  std::string text =
      "group,data_set,orientation_deg,points,mask_iou,method,mean_m,variance_m2,percentile_95_m,"
      "max_m,back_mean_m,back_max_m,centroid_error,normal_error_rad,jaccard,moved_m,turned_rad,"
      "vote,confidence,seconds,"
      "watertight,problem\n";
  for (const CaseResult& result : results) {
    const std::string head = fmt::format("{},{},{},{},{:.4f}", result.group, result.data_set,
                                         result.orientation, result.points, result.mask_iou);
    if (result.methods.empty()) {
      text += fmt::format("{},,,,,,,,,,,,,,,,,{}\n", head, quoted(result.problem));
    }
    for (const MethodResult& m : result.methods) {
      text += fmt::format(
          "{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},"
          "{:.6g},{:.4g},{:.4g},{},{}\n",
          head, m.method, m.mean, m.variance, m.percentile_95, m.max, m.back_mean, m.back_max,
          m.centroid_error, m.normal_error, m.jaccard, m.moved, m.turned, m.vote, m.confidence,
          m.seconds, m.watertight, quoted(m.problem));
    }
  }
  return text;
}

std::vector<Goal> judge(const std::vector<CaseResult>& results) {
  const auto data_set = [](const CaseResult& r) { return r.data_set; };
  const auto orientation = [](const CaseResult& r) {
    return std::to_string(r.orientation) + " deg";
  };
  const SummaryTable by_object = summarize(results, data_set, deviation_of);
  const SummaryTable by_orientation = summarize(results, orientation, deviation_of);
  std::vector<CaseResult> asymmetric;
  std::copy_if(results.begin(), results.end(), std::back_inserter(asymmetric),
               [](const CaseResult& r) { return !r.symmetric; });

  std::vector<Goal> goals;
  goals.push_back(at_most("Mir7 (the paper's method), mean deviation", 7 * kMillimetre,
                          total(results, "Mir7", deviation_of).mean, 1000, "mm"));
  goals.push_back(at_most("Ours, mean deviation", 4 * kMillimetre,
                          total(results, "Ours", deviation_of).mean, 1000, "mm"));
  goals.push_back(never_worse("Ours against Mir7 on every data set", by_object, "Ours", "Mir7",
                              0.5 * kMillimetre));
  goals.push_back(
      never_worse("Ours against Del at every orientation", by_orientation, "Ours", "Del", 0));
  goals.push_back(
      at_most("Ours, centroid error over the diagonal", 0.04,
              total(results, "Ours", [](const MethodResult& m) { return m.centroid_error; }).mean,
              100, "%"));
  goals.push_back(calibrated(results));
  goals.push_back(never_worse("Ours against the fall-back on asymmetric objects",
                              summarize(asymmetric, data_set, deviation_of), "Ours", "Ext", 0));
  int without_mesh = 0;
  for (const CaseResult& result : results) {
    const MethodResult* ours = method_of(result, "Ours");
    without_mesh += ours == nullptr || !ours->watertight;
  }
  goals.push_back({"cases without a watertight mesh of ours", "0",
                   fmt::format("{} of {}", without_mesh, results.size()),
                   outcome_of(without_mesh == 0)});
  return goals;
}

std::string to_string(Goal::Outcome outcome) {
  switch (outcome) {
    case Goal::Outcome::kMet:
      return "pass";
    case Goal::Outcome::kMissed:
      return "MISS";
    case Goal::Outcome::kNotMeasured:
      break;
  }
  return "-";
}

}  // namespace prehend::eval
