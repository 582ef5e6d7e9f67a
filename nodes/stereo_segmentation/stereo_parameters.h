#pragma once

#include "prehend/graph/node.h"
#include "prehend/perception/stereo.h"

namespace prehend::nodes {

/// What is looked at and how a stereo pair is matched, as parameters; see perception/stereo.h.
void declare_stereo_parameters(graph::Node& node);

/// A depth image is not matched: what is given for it would do nothing.
/// @throws geometry::InputError naming the parameter of matching that was given.
void refuse_stereo_parameters(const graph::Node& node);

/// Of the parameters' values now.
perception::StereoOptions stereo_options(const graph::Node& node);

}  // namespace prehend::nodes
