#pragma once

#include "prehend/perception/segmentation.h"
#include "prehend/perception/table.h"

namespace prehend::graph {
class Node;
}

// The parameters of every node that finds a table and objects on it.
namespace prehend::nodes {

/// Declares one parameter for each knob; defaults are those of the options.
void declare_segmentation_parameters(graph::Node& node);

/// The parameters' values now. They may be changed at run time.
perception::TableOptions table_options(const graph::Node& node);
perception::SegmentationOptions segmentation_options(const graph::Node& node);

}  // namespace prehend::nodes
