#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/motion/path_planner.h"
#include "prehend/text/plug_ins.h"

namespace prehend::motion {

inline constexpr const char* kDefaultPlanner = "rrt_connect";

/// Planners by name: `rrt_connect` (the default), `ompl_rrt_connect`, `ompl_bitrrt`, `ompl_kpiece`,
/// and each plug-in in the folders of PREHEND_PLANNERS and in ../lib/prehend/planners beside
/// the running program (text::plug_in_folders()).
class PlannerRegistry {
 public:
  PlannerRegistry();
  explicit PlannerRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return planners_.names(); }  // sorted
  /// @throws std::invalid_argument naming the nearest and all that there are.
  std::unique_ptr<PathPlanner> create(const std::string& name) const;
  const std::vector<text::PlugInProblem>& problems() const { return planners_.problems(); }

 private:
  text::NamedPlugIns<PathPlanner> planners_;
};

}  // namespace prehend::motion
