#pragma once

#include "nodes/report/collected.h"
#include "prehend/report/page.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// The robot and the objects over the run, to be turned and played: links where the joints' states
/// had them, the objects' predicted meshes. Where a simulation told where bodies were, what was
/// grasped goes with its body, else with the hand from the lift to the release.
/// @param frames at most; they are a tenth of a second apart at least.
/// @throws geometry::InputError in words when nothing moved, or the page's program is not there.
void add_film(report::Page& page, const Collected& collected, const robot::Platform& platform,
              int frames = 240);

}  // namespace prehend::nodes
