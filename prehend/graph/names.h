#pragma once

#include <map>
#include <string>

namespace prehend::graph {

/// Checks a node name: letters, digits and '_', not starting with a digit.
/// Throws std::invalid_argument naming the fault.
void check_node_name(const std::string& name);

/// Checks a topic, service or action name: '/' before each part, parts of letters, digits and '_',
/// e.g. "/camera/left". Throws std::invalid_argument naming the fault.
void check_resource_name(const std::string& name);

/// Name -> name in the graph. Both may end with "/*", which is whatever a name has there:
/// "/tactile/*" -> "/left/tactile/*" makes "/tactile/thumb" "/left/tactile/thumb".
using Remaps = std::map<std::string, std::string>;

/// Checks both names of a remap. Throws std::invalid_argument naming the fault.
void check_remap(const std::string& from, const std::string& to);

/// The remap of a name, of those that fit the longest; remaps.end() where none does.
Remaps::const_iterator remap_of(const Remaps& remaps, const std::string& name);

/// What a remap that fits makes of a name.
std::string renamed(const Remaps::value_type& remap, const std::string& name);

/// Checks a namespace: "" for none, else as a resource name, e.g. "/left".
/// Throws std::invalid_argument naming the fault.
void check_name_space(const std::string& name_space);

/// True for the names that are the same in every namespace: /clock, /log, /diagnostics and
/// /statistics, and what lies below them.
bool is_global_name(const std::string& name);

/// "/left" and "/camera" give "/left/camera"; a global name stays as it is.
std::string in_name_space(const std::string& name_space, const std::string& name);

}  // namespace prehend::graph
