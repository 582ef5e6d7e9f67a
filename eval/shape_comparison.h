#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/case_result.h"
#include "eval/deviation_summary.h"

namespace prehend::eval {

/// A column of a comparison's table of methods.
struct MethodColumn {
  std::string title;  // with the unit
  std::string key;    // in JSON, with the SI unit
  double scale = 1;   // from SI units to the title's
  FigureOf figure_of;
  bool with_spread = true;  // mean +- deviation over the cases, else the mean alone
};

/// What is compared with what, and by which figures.
struct ShapeComparison {
  std::string name;
  std::string description;           // one line
  std::vector<std::string> methods;  // of known_methods()
  /// Bodies come to rest on the table before they are seen (resting_pose()), and each mesh is
  /// measured as a solid as well: Jaccard index and settled(). Else they stand as their data says.
  bool as_solids = false;
  std::vector<MethodColumn> columns;
  std::function<std::vector<Goal>(const std::vector<CaseResult>&)> judge;
};

/// "paper": the published methods and ours by the figures of the paper, judge(). "single_view":
/// ours beside the methods of others for one view, judge_single_view().
const std::vector<ShapeComparison>& shape_comparisons();

/// [m], mean of both directions' mean distances.
double chamfer_of(const MethodResult& result);
/// [m], the larger of both directions' largest distances.
double hausdorff_of(const MethodResult& result);
/// 1 when the solid stands where it was seen: moved by at most 5 mm and turned by at most 5
/// degrees; 0 when not, and without a mesh.
double stands_of(const MethodResult& result);

/// "Ours" stands in 98 % of the cases, takes 60 ms, and is best of all methods but the truth in
/// every other column of the comparison "single_view".
std::vector<Goal> judge_single_view(const std::vector<CaseResult>& results);

}  // namespace prehend::eval
