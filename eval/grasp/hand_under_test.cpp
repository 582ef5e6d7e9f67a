#include "eval/grasp/hand_under_test.h"

namespace prehend::eval {

grasp::PlannerOptions options_for(const robot::HandModel& hand, const PlannerSetting& setting) {
  grasp::PlannerOptions options = grasp::default_options(hand);
  if (setting.change) setting.change(&options);
  options.threads = 1;
  return options;
}

double mean_distance(const std::vector<Eigen::Vector3d>& points_W,
                     const geometry::MeshQuery& surface_W) {
  double sum = 0;
  for (const auto& p_W : points_W) sum += surface_W.nearest(p_W)->distance;
  return sum / static_cast<double>(points_W.size());
}

}  // namespace prehend::eval
