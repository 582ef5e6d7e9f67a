#pragma once

#include <string>
#include <vector>

#include "nodes/report/collected.h"
#include "prehend/geometry/image.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// "finger_1_distal" as people write it.
std::string in_words(std::string name);

/// A pad whose texels show `values`, by its cells where the robot says them, else by its rows and
/// columns. @param full the value of the brightest.
geometry::ColorImage draw_pad(const std::vector<double>& values, const std::string& pad, int rows,
                              int columns, const Collected& collected, double full);

/// What each pad felt at the end of the cycle's phases, beside what it was predicted to feel in the
/// grasp that was executed last; why that was not predicted, if so.
void add_touch(report::Page& page, const Collected& collected);

}  // namespace prehend::nodes
