#pragma once

#include <string>
#include <vector>

namespace prehend::tools {

/// Prints rows in aligned columns, the first row as heading.
void print_table(const std::vector<std::vector<std::string>>& rows);

/// "a, b, c"
std::string joined(const std::vector<std::string>& words, const std::string& separator = ", ");

}  // namespace prehend::tools
