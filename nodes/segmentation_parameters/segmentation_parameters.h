#pragma once

#include "prehend/perception/segmentation.h"
#include "prehend/perception/table.h"

namespace prehend::graph {
class Node;
}

// The parameters of every node that finds a table and objects on it.
namespace prehend::nodes {

/// Declares one parameter for each knob; defaults are those of the options. `at_start`: the node
/// segments once when it starts, so they are read-only.
void declare_segmentation_parameters(graph::Node& node, bool at_start);

/// The parameters' values now.
perception::TableOptions table_options(const graph::Node& node);
perception::SegmentationOptions segmentation_options(const graph::Node& node);

}  // namespace prehend::nodes
