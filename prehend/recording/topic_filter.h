#pragma once

#include <optional>
#include <string>
#include <vector>

namespace prehend::recording {

/// Which topics are wanted, by patterns as the shell has them: `*` any text, also with '/', `?` one
/// character, `[abc]` one of them. A name without these matches itself only.
struct TopicFilter {
  std::vector<std::string> include;  ///< empty: all
  std::vector<std::string> exclude;  ///< counts more than include

  bool wants(const std::string& topic) const;

  /// A pattern of either list that matches none of `topics`: a misspelt name would select nothing
  /// silently.
  std::optional<std::string> unmatched(const std::vector<std::string>& topics) const;
};

}  // namespace prehend::recording
