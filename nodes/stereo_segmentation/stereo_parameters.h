#pragma once

#include "prehend/graph/node.h"
#include "prehend/perception/stereo.h"

namespace prehend::nodes {

/// What is looked at and how a stereo pair is matched, as parameters; see perception/stereo.h.
void declare_stereo_parameters(graph::Node& node);

/// What is given, and would do nothing: parameters of matching where depth images are looked at,
/// and a `subpixel_window` for what is not matched by one pass of semi_global.
/// @throws geometry::InputError naming the parameter.
void refuse_idle_stereo_parameters(const graph::Node& node);

/// Of the parameters' values now.
perception::StereoOptions stereo_options(const graph::Node& node);

}  // namespace prehend::nodes
