#pragma once

#include <optional>

#include "prehend/shape/plane_search.h"

namespace prehend::shape {

/// The plane perpendicular to `first` that the points completed at it contradict least, when that
/// is little and enough of them come to lie on what was seen. A first plane along the line of
/// sight leaves the far side open: then any plane that is not contradicted is better than none.
/// `ballot` is what chose `first` in `view`; `map` is what that view saw.
std::optional<SymmetryHypothesis> second_plane(const Ballot& ballot, const Candidate& first,
                                               const ObjectView& view, const SeenMap& map,
                                               const CompletionOptions& options);

}  // namespace prehend::shape
