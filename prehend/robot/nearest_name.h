#pragma once

#include <string>
#include <vector>

namespace prehend::robot {

/// The one of `names` that the fewest single-letter edits turn into `word` (V. I. Levenshtein,
/// 1966); of equals the first, "" when there are none. For error messages.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace prehend::robot
