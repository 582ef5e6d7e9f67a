#include "prehend/recording/word_list.h"

#include <iomanip>
#include <sstream>

namespace prehend::recording {

std::vector<std::string> split_words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> std::quoted(word);) words.push_back(word);
  return words;
}

std::string joined_words(const std::vector<std::string>& words) {
  std::ostringstream stream;
  for (const std::string& word : words) {
    if (stream.tellp() > 0) stream << ' ';
    if (word.empty() || word.find_first_of(" \t\r\n\v\f\"\\") != std::string::npos) {
      stream << std::quoted(word);
    } else {
      stream << word;
    }
  }
  return stream.str();
}

}  // namespace prehend::recording
