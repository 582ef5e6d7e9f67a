#include "prehend/graph/parameter_list.h"

#include <stdexcept>

namespace prehend::graph {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kMarks = ",[]\"";

class ListReader {
 public:
  explicit ListReader(std::string_view text) : text_(text) {}

  std::vector<std::string> read() {
    skip_space();
    if (!take('[')) refuse("a list between brackets, as in [1, 2]");
    std::vector<std::string> items;
    skip_space();
    if (!take(']')) {
      do {
        items.push_back(read_item());
      } while (take(','));
      if (!take(']')) refuse("a list with commas between its items and ] at its end");
    }
    skip_space();
    if (at_ != text_.size()) refuse("a list with nothing after its ]");
    return items;
  }

 private:
  std::string read_item() {
    skip_space();
    std::string item = take('"') ? read_quoted() : read_plain();
    skip_space();
    return item;
  }

  std::string read_plain() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && kMarks.find(text_[at_]) == std::string_view::npos) ++at_;
    std::string_view item = text_.substr(begin, at_ - begin);
    while (!item.empty() && kSpace.find(item.back()) != std::string_view::npos) {
      item.remove_suffix(1);
    }
    if (item.empty()) refuse("a list without empty items (\"\" is an empty text)");
    return std::string(item);
  }

  std::string read_quoted() {
    std::string item;
    while (at_ < text_.size() && text_[at_] != '"') {
      if (text_[at_] == '\\') ++at_;
      if (at_ == text_.size()) break;
      item += text_[at_++];
    }
    if (!take('"')) refuse("a list whose quotes are closed");
    return item;
  }

  void skip_space() {
    while (at_ < text_.size() && kSpace.find(text_[at_]) != std::string_view::npos) ++at_;
  }

  bool take(char mark) {
    if (at_ == text_.size() || text_[at_] != mark) return false;
    ++at_;
    return true;
  }

  [[noreturn]] static void refuse(const char* expected) { throw std::invalid_argument(expected); }

  std::string_view text_;
  std::size_t at_ = 0;
};

bool needs_quotes(const std::string& item) {
  return item.empty() || item.find_first_of(",[]\"\\") != std::string::npos ||
         kSpace.find(item.front()) != std::string_view::npos ||
         kSpace.find(item.back()) != std::string_view::npos;
}

}  // namespace

std::vector<std::string> split_list(std::string_view text) { return ListReader(text).read(); }

std::string join_list(const std::vector<std::string>& items) {
  std::string text = "[";
  for (const std::string& item : items) {
    if (text.size() > 1) text += ", ";
    if (!needs_quotes(item)) {
      text += item;
      continue;
    }
    text += '"';
    for (const char c : item) {
      if (c == '"' || c == '\\') text += '\\';
      text += c;
    }
    text += '"';
  }
  return text + "]";
}

}  // namespace prehend::graph
