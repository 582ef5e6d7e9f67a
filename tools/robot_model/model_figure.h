#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "prehend/report/robot_figure.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::tools {

/// A description as a figure that can be turned and moved, and what of it is not drawn as it is.
struct ModelFigure {
  report::RobotFigure figure;
  std::vector<std::string> remarks;
};

/// Layers: what is seen, what is touched, boxes as heavy and as inert as the links, sensors and
/// pads, tools, ends of closed loops. Joints start at 0, or the limit nearest to it.
/// Meshes have about 300,000 triangles in all; `remarks` says which have fewer than their files.
/// @param folder from which meshes are found, as of find_mesh_file(); those that are not read are
///     not drawn: check_model() says why
/// @throws as robot::formats::tree_order(), and geometry::InputError above 2,000 links, which no
///     page draws.
ModelFigure model_figure(const robot::formats::RobotDescription& robot,
                         const std::filesystem::path& folder);

}  // namespace prehend::tools
