#include "prehend/recording/topic_filter.h"

#include <fnmatch.h>

#include <algorithm>

namespace prehend::recording {
namespace {

bool matches(const std::string& pattern, const std::string& topic) {
  return ::fnmatch(pattern.c_str(), topic.c_str(), 0) == 0;
}

bool any_matches(const std::vector<std::string>& patterns, const std::string& topic) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const std::string& pattern) { return matches(pattern, topic); });
}

}  // namespace

bool TopicFilter::wants(const std::string& topic) const {
  return (include.empty() || any_matches(include, topic)) && !any_matches(exclude, topic);
}

std::optional<std::string> TopicFilter::unmatched(const std::vector<std::string>& topics) const {
  for (const auto* patterns : {&include, &exclude}) {
    for (const std::string& pattern : *patterns) {
      const bool found = std::any_of(topics.begin(), topics.end(), [&](const std::string& topic) {
        return matches(pattern, topic);
      });
      if (!found) return pattern;
    }
  }
  return std::nullopt;
}

}  // namespace prehend::recording
