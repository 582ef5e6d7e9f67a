#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "msgs/actions.pb.h"
#include "msgs/grasp.pb.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

using Plans = std::map<std::uint32_t, std::shared_ptr<const msgs::GraspPlan>>;

/// The id of the planned object whose centroid is nearest to `p_W` [m]: ids are of one view. -1
/// without plans.
int nearest_object(const Plans& plans, const Eigen::Vector3d& p_W);

/// What the cycles need to see again what they failed to grasp: time to wait, and a picture.
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
  std::optional<graph::ServiceClient<msgs::Empty, msgs::Acknowledge>> render_;
  std::optional<double> asked_;  // s
  std::string problem_;
};

}  // namespace prehend::nodes
