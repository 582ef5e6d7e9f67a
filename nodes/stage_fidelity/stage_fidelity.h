#pragma once

#include <optional>
#include <string>
#include <vector>

#include "msgs/objects.pb.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::graph {
class Node;
}

// The parameters of the nodes whose knobs a measured front chooses: of their own stage, or of the
// whole chain, of which each node takes its own part.
namespace prehend::nodes {

/// A point of the front.
struct ChosenStage {
  fidelity::Setting setting;    // the knobs of the node's stage, without the stage's name
  msgs::FidelityChoice choice;  // the knobs of all stages, what they measured, and the front
};

/// What a node was asked for.
class StageFidelity {
 public:
  /// Declares `front`, `budget`, `tolerance`, `task` and `tasks` and reads them: the most accurate
  /// setting within a budget, or the fastest within a tolerance, of the parameters or the task's.
  /// Logs what was chosen, and reports an error when nothing could be.
  /// @param chosen_by_front the node's own parameters that a front sets.
  /// @throws geometry::InputError when one of those is given beside a budget or tolerance, when
  /// task and parameters both have one, when the task cannot be read, and when nothing of the front
  /// keeps what it asks for.
  StageFidelity(graph::Node& node, fidelity::Stage stage,
                const std::vector<std::string>& chosen_by_front);

  /// None when neither a budget nor a tolerance was given: the node's own knobs count.
  /// @throws geometry::InputError when both are given, the front cannot be read, or no setting of
  /// it keeps the budget or tolerance (naming the nearest one).
  const std::optional<ChosenStage>& chosen() const;

 private:
  std::optional<ChosenStage> chosen_;
  std::optional<geometry::InputError> problem_;
};

}  // namespace prehend::nodes
