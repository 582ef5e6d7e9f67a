#pragma once

#include <string>
#include <vector>

#include "nodes/report/collected.h"

namespace prehend::nodes {

/// What the simulator says about a body that was raised.
struct Lift {
  std::string body;       // empty: nothing was raised
  double raised = 0;      // m, highest over its first height
  double moved = 0;       // m, horizontally, between first and last
  double end_height = 0;  // m, last height over the table
};
/// Of all that were raised at all, the highest first.
std::vector<Lift> measure_lifts(const Collected& collected);

/// The grasp that the cycle executed last; nullptr when it executed none, or its plan is not known.
const msgs::Grasp* executed_grasp(const Collected& collected);

/// How far a grasp can be relied on: in how many disturbed trials it held, and what is to know of
/// it, e.g. that it touches surface that nobody saw.
std::string trust_text(const msgs::Grasp& grasp);

/// How the run ended.
struct Verdict {
  enum class Kind {
    kSuccess,       // an object was raised by 100 mm and put down, elsewhere if the task places it
    kNotGraspable,  // nothing could be tried, as no grasp was found: an answer, not a failure
    kFailure
  };
  Kind kind = Kind::kFailure;
  std::string text;  // one sentence for people
};

/// `timeout_reason`: not empty when the run did not end by itself.
Verdict judge(const Collected& collected, const std::string& timeout_reason);

}  // namespace prehend::nodes
