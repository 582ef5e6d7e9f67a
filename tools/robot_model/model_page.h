#pragma once

#include <filesystem>

#include "prehend/report/page.h"
#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::tools {

/// A robot to look at: its figure with sliders, what check_model() finds, tables of joints, links
/// and all else, and what of its file is not in them. Where model_figure() refuses,
/// the page says why.
/// @param folder from which meshes are found, as of find_mesh_file()
report::Page model_page(const robot::formats::RobotDescription& robot,
                        const robot::formats::LossReport& loss,
                        const std::filesystem::path& folder);

}  // namespace prehend::tools
