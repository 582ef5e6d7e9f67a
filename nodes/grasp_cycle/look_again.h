#pragma once

#include <optional>
#include <string>

#include "msgs/actions.pb.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What the cycle needs to see again what it failed to grasp: time to wait, and a picture.
class LookAgain {
 public:
  /// Declares the parameter `look_timeout`.
  explicit LookAgain(graph::Node& node);

  double timeout() const { return timeout_; }  // s, 0: never look again

  /// Asks a simulated camera for a picture of what is there `since` [s], once for each such time.
  /// Cameras that send pictures all the time need not be asked, and do not answer.
  void ask(double since);
  /// Why no picture comes, in words, since the last ask(); empty: it may come.
  const std::string& problem() const { return problem_; }

 private:
  graph::Node& node_;
  double timeout_;
  /// Made when it is needed: a node declares its parameters before it makes anything else.
  std::optional<graph::ServiceClient<msgs::RenderRequest, msgs::Acknowledge>> render_;
  std::optional<double> asked_;  // s
  std::string problem_;
};

}  // namespace prehend::nodes
