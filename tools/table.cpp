#include "tools/table.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace prehend::tools {

void print_table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  const bool bold = ::isatty(STDOUT_FILENO) == 1;
  for (const auto& row : rows) {
    const bool heading = &row == &rows.front() && bold;
    if (heading) std::printf("\x1b[1m");
    for (std::size_t i = 0; i < row.size(); ++i) {
      const int width = i + 1 < row.size() ? static_cast<int>(widths[i]) + 2 : 0;
      std::printf("%-*s", width, row[i].c_str());
    }
    std::printf(heading ? "\x1b[0m\n" : "\n");
  }
}

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

}  // namespace prehend::tools
