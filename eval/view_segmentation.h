#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "eval/segmentation_accuracy.h"

namespace prehend::eval {

/// How one case was seen.
struct ViewSegmentation {
  std::string case_name;
  std::string group;
  std::string data_set;
  SegmentationRun seen;  // of the case's object and the other bodies of its scene
};

/// Renders the scene, measures depth by its sensor and segments it; the condition is left empty.
/// Without a table everything is missed.
SegmentationRun segment_rendered(const RenderedScene& rendered,
                                 const perception::SegmentationOptions& segmentation = {});
/// Renders the case with all that is in its scene, measures depth by its sensor and segments it.
ViewSegmentation segment_view(const Case& one,
                              const perception::SegmentationOptions& segmentation = {});

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const ViewSegmentation& view);
ViewSegmentation read_view(const std::string& text);

/// The views of each group, by its name, in the order of their first; counts added, depth errors
/// (medians of a view) and times averaged.
std::vector<SegmentationRun> by_group(const std::vector<ViewSegmentation>& views);
/// The same of each data set, as "group: name".
std::vector<SegmentationRun> by_data_set(const std::vector<ViewSegmentation>& views);

}  // namespace prehend::eval
