#pragma once

#include "msgs/belief.pb.h"
#include "msgs/percepts.pb.h"
#include "nodes/belief/act_forecasts.h"
#include "nodes/held_picture/held_picture.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// Serves /percepts/view: what the graph's camera shows of what a hand has lifted, as it is
/// foretold, too.
class LiftViewServer {
 public:
  /// Declares the parameter `view_patience`. `platform` and `forecasts` live longer.
  LiftViewServer(graph::Node& node, const robot::Platform& platform, const ActForecasts& forecasts);

 private:
  using Context = graph::ActionContext<msgs::LiftViewFeedback>;
  msgs::LiftViewResult view(const msgs::HeldLookGoal& goal, Context& context);

  graph::Node& node_;
  const ActForecasts& forecasts_;
  double patience_;  // s
  HeldPictures pictures_;
  graph::ActionServer server_;
};

}  // namespace prehend::nodes
