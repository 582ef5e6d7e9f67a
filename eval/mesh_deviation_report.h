#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/case_result.h"
#include "eval/reconstruction_methods.h"
#include "eval/shape_comparison.h"

namespace prehend::eval {

/// By the comparison's columns and goals. Writes into `folder`: index.html (goals, figures and
/// tables of each group), cases.csv, and of each group the figures as GROUP_NAME.csv and .svg:
///  - deviation_by_orientation, deviation_by_object: mean distance of the truth to the mesh [mm];
///  - centroid_by_orientation, centroid_by_object: [% of the diagonal];
///  - vote_by_orientation: of the chosen plane.
/// @throws std::runtime_error naming a file that cannot be written.
void write_mesh_deviation_report(const std::filesystem::path& folder,
                                 const std::vector<CaseResult>& results,
                                 const std::vector<Method>& methods,
                                 const ShapeComparison& comparison);

/// The groups' goals and each method's totals as one JSON object.
std::string mesh_deviation_json(const std::vector<CaseResult>& results,
                                const std::vector<Method>& methods,
                                const ShapeComparison& comparison);

/// The same for people, to be printed.
std::string mesh_deviation_text(const std::vector<CaseResult>& results,
                                const std::vector<Method>& methods,
                                const ShapeComparison& comparison);

}  // namespace prehend::eval
