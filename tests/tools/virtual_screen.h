#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

namespace prehend::testing {

/// What a terminal of 80 x 24 characters shows after some bytes: as much of ECMA-48 as ncurses
/// sends to an xterm or a vt100.
class VirtualScreen {
 public:
  void write(const std::string& bytes) {
    for (const char byte : bytes) take(byte);
  }
  /// Lines, without the blanks at their ends.
  std::string text() const {
    std::string all;
    for (std::string line : lines_) {
      line.erase(line.find_last_not_of(' ') + 1);
      all += line + "\n";
    }
    return all;
  }

 private:
  static constexpr int kColumns = 80, kRows = 24;

  void take(char byte) {
    if (escape_.empty()) return plain(byte);
    escape_ += byte;
    if (escape_.size() == 2) {
      // A control sequence goes on; so does a character set's choice, by one more.
      if (byte != '[' && byte != '(' && byte != ')' && byte != ']') escape_.clear();
      return;
    }
    if (escape_[1] == '(' || escape_[1] == ')') return escape_.clear();
    if (escape_[1] == ']') {
      if (byte == '\a') escape_.clear();
      return;
    }
    if (byte < '@' || byte > '~') return;
    control(byte, escape_.substr(2, escape_.size() - 3));
    escape_.clear();
  }
  void plain(char byte) {
    switch (byte) {
      case '\x1b':
        escape_ = byte;
        return;
      case '\r':
        column_ = 0;
        return;
      case '\n':
        row_ = std::min(row_ + 1, kRows - 1);
        return;
      case '\b':
        column_ = std::max(0, column_ - 1);
        return;
      case '\t':
        column_ = std::min(kColumns - 1, (column_ / 8 + 1) * 8);
        return;
      default:
        if (static_cast<unsigned char>(byte) < 32) return;
        if (column_ >= kColumns) {
          column_ = 0;
          row_ = std::min(row_ + 1, kRows - 1);
        }
        last_ = byte;
        line()[static_cast<std::size_t>(column_++)] = byte;
    }
  }
  void control(char kind, const std::string& parameters) {
    if (!parameters.empty() && parameters[0] == '?') return;
    std::vector<int> numbers;
    std::size_t begin = 0;
    while (begin <= parameters.size()) {
      const std::size_t end = std::min(parameters.find(';', begin), parameters.size());
      numbers.push_back(std::atoi(parameters.substr(begin, end - begin).c_str()));
      begin = end + 1;
    }
    const int first = numbers[0], count = std::max(1, first);
    const auto at = static_cast<std::size_t>(std::min(column_, kColumns - 1));
    switch (kind) {
      case 'H':
      case 'f':
        row_ = std::clamp(count - 1, 0, kRows - 1);
        column_ =
            std::clamp((numbers.size() > 1 ? std::max(1, numbers[1]) : 1) - 1, 0, kColumns - 1);
        return;
      case 'A':
        row_ = std::max(0, row_ - count);
        return;
      case 'B':
        row_ = std::min(kRows - 1, row_ + count);
        return;
      case 'C':
        column_ = std::min(kColumns - 1, column_ + count);
        return;
      case 'D':
        column_ = std::max(0, column_ - count);
        return;
      case 'G':
        column_ = std::clamp(count - 1, 0, kColumns - 1);
        return;
      case 'd':
        row_ = std::clamp(count - 1, 0, kRows - 1);
        return;
      case 'K':
        if (first == 0) std::fill(line().begin() + static_cast<long>(at), line().end(), ' ');
        if (first == 1) std::fill(line().begin(), line().begin() + static_cast<long>(at) + 1, ' ');
        if (first == 2) line().assign(kColumns, ' ');
        return;
      case 'J':
        if (first == 0) {
          control('K', "");
          for (int row = row_ + 1; row < kRows; ++row) {
            lines_[static_cast<std::size_t>(row)].assign(kColumns, ' ');
          }
        } else {
          lines_.assign(kRows, std::string(kColumns, ' '));
        }
        return;
      case 'X':
        for (int i = 0; i < count && column_ + i < kColumns; ++i) {
          line()[static_cast<std::size_t>(column_ + i)] = ' ';
        }
        return;
      case 'P':
        line().erase(at, static_cast<std::size_t>(count));
        line().resize(kColumns, ' ');
        return;
      case '@':
        line().insert(at, static_cast<std::size_t>(count), ' ');
        line().resize(kColumns);
        return;
      case 'b':
        for (int i = 0; i < count; ++i) plain(last_);
        return;
      default:  // colours, modes
        return;
    }
  }
  std::string& line() { return lines_[static_cast<std::size_t>(row_)]; }

  std::vector<std::string> lines_ = std::vector<std::string>(kRows, std::string(kColumns, ' '));
  int row_ = 0, column_ = 0;
  char last_ = ' ';
  std::string escape_;
};

}  // namespace prehend::testing
