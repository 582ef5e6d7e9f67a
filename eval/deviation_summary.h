#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/case_result.h"

namespace prehend::eval {

/// Mean and standard deviation of some cases' figures; NaN ones are left out.
struct Spread {
  double mean = kUnknown;
  double deviation = kUnknown;
  int count = 0;
};
Spread spread_of(const std::vector<double>& values);

/// A figure of a result, e.g. the mean deviation [m].
using FigureOf = std::function<double(const MethodResult&)>;

/// [m], the mean distance to the truth.
inline double deviation_of(const MethodResult& m) { return m.mean; }

/// Whether the mesh is what a sure completion promises: within 5 mm of the truth on average, and
/// the truth of it. What was merged with another covers the truth, but is not near it.
bool is_right(const MethodResult& result);

/// The row a case falls into, e.g. its orientation.
using RowOf = std::function<std::string(const CaseResult&)>;

/// One figure for each row and method, over the cases of that row.
struct SummaryTable {
  std::vector<std::string> rows;  // in the order of their first case
  std::vector<std::string> methods;
  std::vector<std::vector<Spread>> cells;  // rows x methods
};
SummaryTable summarize(const std::vector<CaseResult>& results, const RowOf& row_of,
                       const FigureOf& figure_of);

/// The spread of a figure of one method over all results.
Spread total(const std::vector<CaseResult>& results, const std::string& method,
             const FigureOf& figure_of);

/// Rows: the row's name, then mean, deviation and count of each method; `scale` multiplies the
/// figures (1000: millimetres). Unknown cells are empty.
std::string to_csv(const SummaryTable& table, const std::string& row_name, double scale);

/// Every figure of every method and case, one line each, in SI units.
std::string cases_csv(const std::vector<CaseResult>& results);

/// One of the bars that the evaluation is held against.
struct Goal {
  enum class Outcome { kMet, kMissed, kNotMeasured };
  std::string name;
  std::string bar;
  std::string measured = "not measured";
  Outcome outcome = Outcome::kNotMeasured;
};

/// The goals on one group of results. "Ours" is compared with Mir7, Del and the fall-back Ext.
std::vector<Goal> judge(const std::vector<CaseResult>& results);

/// "pass", "MISS" or "-".
std::string to_string(Goal::Outcome outcome);

}  // namespace prehend::eval
