#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace prehend::text {

/// Number of insertions, deletions, substitutions and swaps of neighbouring bytes that turn one
/// word into the other, no part being edited twice (restricted Damerau-Levenshtein distance;
/// F. J. Damerau, "A technique for computer detection and correction of spelling errors",
/// CACM 7(3), 1964). Case matters. O(|a| |b|) time.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that was probably meant by `word`: the one at the least edit distance (a different
/// case counts as nothing), provided that this is at most a third of the longer word's length, and
/// at least 1 is always allowed. A candidate that `word` begins or ends counts as near, too. Ties
/// go to the earlier candidate. Empty when nothing is near.
std::optional<std::string> nearest_match(std::string_view word,
                                         const std::vector<std::string>& candidates);

/// The end of an error message: `; did you mean "x"?`, else `; known are: a, b, c` (at most eight
/// names, in the given order), else `` when there are no candidates.
std::string nearest_match_hint(std::string_view word, const std::vector<std::string>& candidates);

/// The same as a sentence of its own, the mend of an InputError: `The nearest is 'x'`, else `Known
/// are a, b, c`, else `There is none to choose from`.
std::string nearest_match_mend(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace prehend::text
