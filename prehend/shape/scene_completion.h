#pragma once

#include <cstddef>
#include <exception>
#include <optional>
#include <vector>

#include "prehend/perception/segmented_scene.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/shape/completion_options.h"

namespace prehend::shape {

/// One of a scene's objects, or why it could not be completed.
struct SceneShape {
  CompletedShape shape;
  std::exception_ptr error;
  double seconds = 0;  // that its completion took

  /// @throws `error`, if there is one.
  const CompletedShape& get() const {
    if (error) std::rethrow_exception(error);
    return shape;
  }
};

/// Every object of `scene`, each by complete_by_symmetry() and for itself, so that one that fails
/// costs no other; then keep_apart(). One for each object, in their order. With `alternatives_of`
/// only that object gets `options.alternatives` and `options.other_methods`.
std::vector<SceneShape> complete_scene(const perception::SegmentedScene& scene,
                                       const CompletionOptions& options = {},
                                       const ConfidenceModel& model = {},
                                       std::optional<std::size_t> alternatives_of = std::nullopt);

}  // namespace prehend::shape
