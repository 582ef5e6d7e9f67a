#pragma once

#include <string>
#include <vector>

namespace prehend::recording {

/// Lists of topics or files in one text parameter: words separated by spaces; one with spaces of
/// its own stands in double quotes, where \\ and \" mean themselves.
std::vector<std::string> split_words(const std::string& text);

/// The text that split_words() takes apart again.
std::string joined_words(const std::vector<std::string>& words);

}  // namespace prehend::recording
