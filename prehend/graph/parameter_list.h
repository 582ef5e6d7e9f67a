#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace prehend::graph {

/// The text form of a list: items between brackets with commas between them, as in
/// [1, 2.5] or [left, "a, b"]. An item in double quotes may hold anything; \" and \\ stand for a
/// quote and a backslash in it. White space round items does not count.

/// The items. Throws std::invalid_argument with what is wrong, to be put after "must be ".
std::vector<std::string> split_list(std::string_view text);

/// The text form; quotes items where that is needed.
std::string join_list(const std::vector<std::string>& items);

}  // namespace prehend::graph
