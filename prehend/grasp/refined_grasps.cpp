#include "prehend/grasp/refined_grasps.h"

#include <utility>

#include "prehend/grasp/parallel.h"

namespace prehend::grasp {

void RefinedGrasps::refine(const std::vector<Listed*>& listed, const Closing& closing,
                           int threads) {
  std::vector<Known> fresh(listed.size());
  for_each_index(listed.size(), threads, [&](std::size_t i) {
    if (known_.contains(listed[i]->order)) return;
    fresh[i].closed = listed[i]->closed;
    fresh[i].refusal = closing.refine(&fresh[i].closed);
  });
  for (std::size_t i = 0; i < listed.size(); ++i) {
    const auto known = known_.try_emplace(listed[i]->order, std::move(fresh[i])).first;
    listed[i]->closed = known->second.closed;
  }
}

const std::optional<Refusal>& RefinedGrasps::refusal(const Listed& listed) const {
  return known_.at(listed.order).refusal;
}

void RefinedGrasps::assess(const std::vector<Listed*>& listed,
                           const std::vector<const Closing*>& on_shapes,
                           const std::vector<double>& weights,
                           const std::vector<Disturbance>& disturbances, int threads,
                           const std::function<bool()>& time_is_up) {
  std::vector<Listed*> open;
  for (Listed* one : listed) {
    if (!known_.at(one->order).robustness) open.push_back(one);
  }
  const std::size_t samples = disturbances.size(), shapes = on_shapes.size();
  std::vector<std::optional<bool>> held(open.size() * samples);
  for_each_index(held.size(), threads, [&](std::size_t i) {
    if (time_is_up()) return;
    const Grasp& grasp = open[i / samples]->grasp();
    const Disturbance& one = disturbances[i % samples];
    held[i] = on_shapes[i % samples % shapes]->holds(grasp, grasp.X_WG * one.X_GD, one.friction);
  });
  for (std::size_t k = 0; k < open.size(); ++k) {
    const Grasp& grasp = open[k]->grasp();
    Robustness& found = known_.at(open[k]->order).robustness.emplace();
    found.held_on_shapes = shares_held(held, k * samples, samples, shapes);
    found.mean = mean_share(found.held_on_shapes, weights).value_or(grasp.robustness);
    if (found.held_on_shapes.empty() || shapes == 1) continue;
    found.stops_on_shapes = {grasp.closed};
    for (std::size_t shape = 1; shape < shapes; ++shape) {
      found.stops_on_shapes.push_back(on_shapes[shape]->stops(grasp));
    }
  }
  for (Listed* one : listed) {
    const Robustness& found = *known_.at(one->order).robustness;
    one->grasp().held_on_shapes = found.held_on_shapes;
    one->grasp().stops_on_shapes = found.stops_on_shapes;
    one->grasp().robustness = found.mean;
  }
}

}  // namespace prehend::grasp
