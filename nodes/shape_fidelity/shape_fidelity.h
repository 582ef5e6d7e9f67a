#pragma once

#include <optional>

#include "msgs/objects.pb.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::graph {
class Node;
}

// The parameters of the nodes that make up what the front "shape" measures.
namespace prehend::nodes {

/// A point of the front: the knobs of all stages, and what they measured.
struct ChosenShape {
  fidelity::ShapeOptions options;
  msgs::FidelityChoice choice;
};

/// What a node was asked for.
class ShapeFidelity {
 public:
  /// Declares `front`, `budget` and `tolerance` and reads them: the most accurate setting within a
  /// budget, or the fastest within a tolerance. Logs what was chosen, and reports an error when
  /// nothing could be.
  explicit ShapeFidelity(graph::Node& node);

  /// None when neither a budget nor a tolerance was given: the node's own knobs count.
  /// @throws geometry::InputError when both are given, the front cannot be read, or no setting of
  /// it keeps the budget or tolerance (naming the nearest one).
  const std::optional<ChosenShape>& chosen() const;

 private:
  std::optional<ChosenShape> chosen_;
  std::optional<geometry::InputError> problem_;
};

}  // namespace prehend::nodes
