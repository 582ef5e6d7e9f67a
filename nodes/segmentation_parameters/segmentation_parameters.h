#pragma once

#include <optional>

#include "prehend/perception/segmentation.h"
#include "prehend/perception/table.h"

namespace prehend::graph {
class Node;
}

namespace prehend::nodes {

/// The parameters of every node that finds a table and objects on it.
class SegmentationParameters {
 public:
  /// Declares one for each knob; defaults are those of the options. `at_start`: the node segments
  /// once when it starts, so they are read-only.
  /// @throws geometry::InputError for a platform that cannot be read.
  SegmentationParameters(graph::Node& node, bool at_start);

  /// Their values now.
  perception::TableOptions table() const;
  /// @throws geometry::InputError when `split` asks for a platform and none is named.
  perception::SegmentationOptions segmentation() const;

 private:
  const graph::Node& node_;
  std::optional<double> widest_opening_;  // m, of the platform's hand; none: no platform is named
};

}  // namespace prehend::nodes
