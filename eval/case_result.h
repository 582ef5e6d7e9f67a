#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "prehend/shape/confidence.h"

namespace prehend::eval {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// How far one method's mesh is from the truth in one case. Lengths in metres.
struct MethodResult {
  std::string method;
  std::string problem;  // why there is no mesh; the figures are NaN then
  // Distances of points spread evenly over the true surface to the mesh (MeshDev's measure).
  double mean = kUnknown;
  double variance = kUnknown;  // m^2
  double percentile_95 = kUnknown;
  double max = kUnknown;
  // The other direction, from the mesh to the truth.
  double back_mean = kUnknown;
  double back_max = kUnknown;
  double centroid_error = kUnknown;  // of the surfaces' centroids, over the truth's diagonal
  double normal_error = kUnknown;    // rad, median over the mesh, to the nearest place of the truth
  // Of the solid, where it was measured as one.
  double jaccard = kUnknown;  // index with the truth, 0..1
  double moved = kUnknown;    // m, its centre of mass when it was let go on the table
  double turned = kUnknown;   // rad, the same
  double vote = kUnknown;
  double confidence = kUnknown;  // 0..1
  double seconds = kUnknown;     // of processor, from segmented cloud to mesh
  bool watertight = false;
  std::optional<shape::Evidence> evidence;  // what the confidence is made of
};

/// One stereo pair: what was seen and what each method made of it.
struct CaseResult {
  std::string case_name;
  std::string group;
  std::string data_set;
  int orientation = 0;  // degrees
  bool symmetric = true;
  std::string problem;         // nothing was segmented, or the process crashed
  int points = 0;              // of the segmented object
  double mask_iou = kUnknown;  // with the rendered truth
  std::vector<MethodResult> methods;
};

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const CaseResult& result);
CaseResult read_case_result(const std::string& text);

}  // namespace prehend::eval
