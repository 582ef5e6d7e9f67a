#pragma once

#include <optional>

#include "msgs/grasp.pb.h"
#include "prehend/fidelity/front.h"
#include "prehend/graph/node.h"
#include "prehend/planning/touch_prediction.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// How what a hand's pads will feel is predicted.
struct TouchParameters {
  std::optional<planning::TouchPredictionOptions> options;  // none: it is not
  std::optional<fidelity::Setting> chosen;  // from the front, and in the options; none: by default
};

/// Declares whether, and how, what a hand's pads will feel is predicted.
TouchParameters declare_touch(graph::Node& node);

/// Declares what the pads of a hand with fingers are to feel [N]; 0: as its motors press.
double declare_grip_force(graph::Node& node);
/// @throws std::invalid_argument when one of these was given for a hand that it means nothing to.
void refuse_touch_parameters(const graph::Node& node, const robot::Platform& platform);

/// Of a plan's times: what predicting touch took.
inline constexpr const char* kTouchStage = "touch_prediction";

/// Logs how long it took to predict touch in a plan, and where it was not.
void log_touch(graph::Node& node, const msgs::GraspPlan& plan);

}  // namespace prehend::nodes
