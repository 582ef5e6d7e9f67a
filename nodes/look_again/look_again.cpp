#include "nodes/look_again/look_again.h"

#include <chrono>
#include <limits>

#include "msgs/convert/geometry.h"

namespace prehend::nodes {

int nearest_object(const Plans& plans, const Eigen::Vector3d& p_W) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [id, plan] : plans) {
    const double distance = (convert::from_message(plan->centroid()) - p_W).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = static_cast<int>(id);
  }
  return nearest;
}

LookAgain::LookAgain(graph::Node& node)
    : node_(node),
      timeout_(node.declare_parameter<double>(
          {.name = "look_timeout",
           .default_value = 60.0,
           .unit = "s",
           .minimum = 0.0,
           .description =
               "after a failed attempt: to wait for a plan of what is there then, before "
               "the next grasp of the plan before is taken; 0: that at once",
           .read_only = true})) {}

void LookAgain::ask(double since) {
  if (asked_ == since) return;
  asked_ = since;
  problem_.clear();
  if (!render_) {
    render_.emplace(node_.client<msgs::Empty, msgs::Acknowledge>("/simulation/render"));
  }
  const std::chrono::duration<double> patience(timeout_);
  render_->call_async({}, std::chrono::duration_cast<std::chrono::nanoseconds>(patience),
                      [this](const graph::Outcome<msgs::Acknowledge>& outcome) {
                        if (outcome.ok() && !outcome->success()) {
                          problem_ = "no picture comes: " + outcome->reason();
                        }
                      });
}

}  // namespace prehend::nodes
