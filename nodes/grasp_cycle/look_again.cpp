#include "nodes/grasp_cycle/look_again.h"

#include <chrono>

namespace prehend::nodes {

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
    render_.emplace(node_.client<msgs::RenderRequest, msgs::Acknowledge>("/simulation/render"));
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
