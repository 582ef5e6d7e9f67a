#include "tools/message_text.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

namespace prehend::tools {
namespace {

using google::protobuf::TextFormat;

constexpr std::size_t kLongestText = 64;  // bytes

class ElidingPrinter : public TextFormat::FastFieldValuePrinter {
 public:
  void PrintBytes(const std::string& bytes,
                  TextFormat::BaseTextGenerator* generator) const override {
    if (bytes.size() <= kLongestText) {
      FastFieldValuePrinter::PrintBytes(bytes, generator);
      return;
    }
    generator->PrintString(std::to_string(bytes.size()).insert(0, 1, '<') + " bytes>");
  }
  void PrintString(const std::string& text,
                   TextFormat::BaseTextGenerator* generator) const override {
    if (text.size() <= kLongestText * 4) {
      FastFieldValuePrinter::PrintString(text, generator);
      return;
    }
    generator->PrintString("<text of " + std::to_string(text.size()) + " bytes>");
  }
};

// Cuts "name: [1, 2, 3, ...]" lines of long repeated numbers.
std::string with_short_lists(const std::string& text) {
  constexpr int kMostNumbers = 16;
  std::string result;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t list = line.find(": [");
    const bool is_list =
        list != std::string::npos && line.back() == ']' && line.find('"') == std::string::npos;
    std::size_t cut = std::string::npos, numbers = 0;
    for (std::size_t at = list; is_list && at != std::string::npos; at = line.find(", ", at + 1)) {
      if (++numbers == kMostNumbers + 1) cut = at;
    }
    result += cut == std::string::npos
                  ? line
                  : line.substr(0, cut) + ", ... " + std::to_string(numbers) + " in all]";
    result += '\n';
  }
  return result;
}

}  // namespace

std::string message_text(const google::protobuf::Message& message, bool full) {
  TextFormat::Printer printer;
  printer.SetUseShortRepeatedPrimitives(true);
  if (!full) printer.SetDefaultFieldValuePrinter(new ElidingPrinter);  // the printer owns it
  std::string text;
  printer.PrintToString(message, &text);
  return full ? text : with_short_lists(text);
}

}  // namespace prehend::tools
