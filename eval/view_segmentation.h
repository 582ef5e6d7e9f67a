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

/// Writes the result as YAML so that the file is whole or absent.
/// @throws geometry::InputError when the folder cannot be written.
void write_view(const std::filesystem::path& file, const ViewSegmentation& view);
/// @throws geometry::InputError naming the file when it is no result.
ViewSegmentation read_view(const std::filesystem::path& file);

/// The views of each group, by its name, in the order of their first; counts added, depth errors
/// (medians of a view) and times averaged.
std::vector<SegmentationRun> by_group(const std::vector<ViewSegmentation>& views);
/// The same of each data set, as "group: name".
std::vector<SegmentationRun> by_data_set(const std::vector<ViewSegmentation>& views);

}  // namespace prehend::eval
