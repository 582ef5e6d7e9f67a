#include "nodes/platform_source/platform_source.h"

#include "prehend/text/tree_file.h"

namespace prehend::nodes {

std::string declare_platforms(graph::Node& node) {
  return node.declare_parameter<std::string>(
      {.name = "platforms",
       .default_value = text::tree_file("config/robots"),
       .description = "folder of the platforms that have names, NAME.yaml",
       .read_only = true});
}

}  // namespace prehend::nodes
