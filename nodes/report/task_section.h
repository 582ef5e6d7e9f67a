#pragma once

#include <optional>

#include "msgs/grasp.pb.h"
#include "prehend/report/page.h"

namespace prehend::nodes {

/// The task's states, with the path that was taken.
void add_task(report::Page& page, const msgs::Task& task,
              const std::optional<msgs::CycleResult>& result);

}  // namespace prehend::nodes
