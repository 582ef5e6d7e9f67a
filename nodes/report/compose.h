#pragma once

#include <string>
#include <vector>

#include "nodes/report/collected.h"
#include "nodes/report/drawn_robot.h"
#include "nodes/report/processes.h"
#include "nodes/report/verdict.h"
#include "prehend/report/page.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// Rows of "what", "value": the run in brief, for terminal and page.
std::vector<std::vector<std::string>> summarize(const Collected& collected);

/// Rows of stage, seconds.
std::vector<std::vector<std::string>> stage_times(const Collected& collected);

/// The whole page. A part that is missing or that cannot be drawn is named in words instead.
report::Page compose_page(const std::string& title, const Collected& collected,
                          const Verdict& verdict, const DrawnRobot& robot,
                          const robot::Platform& platform, const std::vector<Process>& processes);

}  // namespace prehend::nodes
