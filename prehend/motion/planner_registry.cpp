#include "prehend/motion/planner_registry.h"

#include "prehend/motion/ompl_planner.h"
#include "prehend/motion/rrt_connect.h"

namespace prehend::motion {
namespace {

template <OmplAlgorithm algorithm>
PathPlanner* create_ompl() {
  return std::make_unique<OmplPlanner>(algorithm).release();
}

PathPlanner* create_rrt_connect() { return std::make_unique<RrtConnect>().release(); }

}  // namespace

PlannerRegistry::PlannerRegistry() : PlannerRegistry(text::plug_in_folders("planner")) {}

PlannerRegistry::PlannerRegistry(const std::vector<std::filesystem::path>& folders)
    : planners_("planner", kPlannerInterface, folders,
                {{kDefaultPlanner, create_rrt_connect},
                 {"ompl_rrt_connect", create_ompl<OmplAlgorithm::kRrtConnect>},
                 {"ompl_bitrrt", create_ompl<OmplAlgorithm::kBiTrrt>},
                 {"ompl_kpiece", create_ompl<OmplAlgorithm::kLbKpiece>}}) {}

std::unique_ptr<PathPlanner> PlannerRegistry::create(const std::string& name) const {
  return std::unique_ptr<PathPlanner>(planners_.find(name)());
}

}  // namespace prehend::motion
