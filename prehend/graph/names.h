#pragma once

#include <string>
#include <vector>

namespace prehend::graph {

/// Checks a node name: letters, digits and '_', not starting with a digit.
/// Throws std::invalid_argument naming the fault.
void check_node_name(const std::string& name);

/// Checks a topic, service or action name: '/' before each part, parts of letters, digits and '_',
/// e.g. "/camera/left". Throws std::invalid_argument naming the fault.
void check_resource_name(const std::string& name);

/// The candidate nearest to `name` by edit distance (Levenshtein), or "" when none is near enough
/// (distance at most 2 or a third of the name's length) to be what was meant.
std::string nearest_match(const std::string& name, const std::vector<std::string>& candidates);

/// " (did you mean 'x'?)" for the nearest match, else " (known: a, b, c)", else "".
std::string suggestion(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace prehend::graph
