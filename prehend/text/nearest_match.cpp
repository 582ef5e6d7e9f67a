#include "prehend/text/nearest_match.h"

#include <algorithm>
#include <cctype>

namespace prehend::text {
namespace {

constexpr std::size_t kMostNamesListed = 8;

std::string lower_case(std::string_view word) {
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

bool begins_or_ends(std::string_view part, std::string_view whole) {
  return part.size() >= 3 && (whole.starts_with(part) || whole.ends_with(part));
}

std::string listed(const std::vector<std::string>& candidates) {
  std::string list;
  for (std::size_t i = 0; i < candidates.size() && i < kMostNamesListed; ++i) {
    if (i > 0) list += ", ";
    list += candidates[i];
  }
  if (candidates.size() > kMostNamesListed) list += ", ...";
  return list;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_previous(b.size() + 1), previous(b.size() + 1),
      current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) current[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_previous.swap(previous);
    previous.swap(current);
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitution = previous[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, substitution});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) current[j] = std::min(current[j], before_previous[j - 2] + 1);
    }
  }
  return current[b.size()];
}

std::optional<std::string> nearest_match(std::string_view word,
                                         const std::vector<std::string>& candidates) {
  const std::string wanted = lower_case(word);
  std::optional<std::string> best;
  std::size_t best_distance = 0;
  for (const std::string& candidate : candidates) {
    const std::string offered = lower_case(candidate);
    const std::size_t longest = std::max(wanted.size(), offered.size());
    const std::size_t allowed = std::max<std::size_t>(1, longest / 3);
    std::size_t distance = edit_distance(wanted, offered);
    if (begins_or_ends(wanted, offered)) distance = std::min(distance, allowed);
    if (distance > allowed || distance >= longest) continue;
    if (!best || distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string nearest_match_hint(std::string_view word, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return "";
  if (const auto near = nearest_match(word, candidates)) return "; did you mean \"" + *near + "\"?";
  return "; known are: " + listed(candidates);
}

std::string nearest_match_mend(std::string_view word, const std::vector<std::string>& candidates) {
  if (candidates.empty()) return "There is none to choose from";
  if (const auto near = nearest_match(word, candidates)) return "The nearest is '" + *near + "'";
  return "Known are " + listed(candidates);
}

}  // namespace prehend::text
