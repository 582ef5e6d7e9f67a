// A planner in a shared library: straight to a goal, or over one random position.

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "prehend/motion/path_planner.h"

namespace {

using prehend::motion::FreeSpace;
using prehend::motion::JointPath;
using prehend::motion::PathOptions;
using prehend::robot::Positions;

class OneStop final : public prehend::motion::PathPlanner {
 public:
  std::string name() const override { return "one_stop"; }
  std::string about() const override { return "straight, or over one random position"; }

  JointPath plan(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                 const std::vector<Positions>& goals, const PathOptions& options) const override {
    const auto begin = std::chrono::steady_clock::now();
    JointPath path;
    const auto reaches = [&](const Positions& from) {
      for (std::size_t g = 0; g < goals.size() && !path.found(); ++g) {
        if (!space.is_free_between(from, goals[g], options.resolution)) continue;
        path.goal = static_cast<int>(g);
        path.waypoints = {start, from, goals[g]};
      }
      return path.found();
    };
    if (reaches(start)) return path;
    std::mt19937_64 random(options.seed);
    std::uniform_real_distribution<double> share(0, 1);
    for (; path.iterations < options.iterations; ++path.iterations) {
      const std::chrono::duration<double> used = std::chrono::steady_clock::now() - begin;
      if (options.budget > 0 && used.count() > options.budget) break;
      Positions stop(space.size());
      for (int i = 0; i < space.size(); ++i) {
        const double low = std::isfinite(space.lower(i)) ? space.lower(i) : -std::numbers::pi;
        const double high = std::isfinite(space.upper(i)) ? space.upper(i) : std::numbers::pi;
        stop[i] = low + (high - low) * share(random);
      }
      if (space.is_free_between(start, stop, options.resolution) && reaches(stop)) return path;
    }
    path.reason =
        "no path over one position was found with " + std::to_string(path.iterations) + " samples";
    return path;
  }
};

}  // namespace

extern "C" {

int prehend_planner_interface() { return prehend::motion::kPlannerInterface; }

prehend::motion::PathPlanner* prehend_create_planner() { return new OneStop; }
}
