#include "tools/message_text.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace prehend::tools {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
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

constexpr std::size_t kMostElements = 16;

class Shortening {
 public:
  // Lists of more than `most_elements` are cut to so many, those of numbers to `kept_elements`.
  Shortening(std::size_t most_elements, std::size_t kept_elements, std::size_t most_bytes)
      : most_elements_(most_elements), kept_elements_(kept_elements), most_bytes_(most_bytes) {}

  void visit(Message& message, const std::string& prefix) {
    const Reflection& reflection = *message.GetReflection();
    std::vector<const FieldDescriptor*> fields;
    reflection.ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
      const std::string name = prefix + field->name();
      if (field->is_repeated()) cut_list(message, *field, name);
      visit_content(message, *field, name);
    }
  }

  std::vector<Shortened> take() { return std::move(cuts_); }

 private:
  void cut_list(Message& message, const FieldDescriptor& field, const std::string& name) {
    const Reflection& reflection = *message.GetReflection();
    const auto size = static_cast<std::size_t>(reflection.FieldSize(message, &field));
    if (size <= most_elements_) return;
    const bool is_numbers = field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE &&
                            field.cpp_type() != FieldDescriptor::CPPTYPE_STRING;
    cuts_.push_back({name, size, true, is_numbers});
    const std::size_t kept = is_numbers ? kept_elements_ : most_elements_;
    for (std::size_t i = kept; i < size; ++i) reflection.RemoveLast(&message, &field);
  }

  void visit_content(Message& message, const FieldDescriptor& field, const std::string& name) {
    const Reflection& reflection = *message.GetReflection();
    const bool is_message = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (!is_message && field.cpp_type() != FieldDescriptor::CPPTYPE_STRING) return;
    const int count = field.is_repeated() ? reflection.FieldSize(message, &field) : 1;
    for (int i = 0; i < count; ++i) {
      const std::string place = field.is_repeated() ? name + '[' + std::to_string(i) + ']' : name;
      if (is_message) {
        visit(field.is_repeated() ? *reflection.MutableRepeatedMessage(&message, &field, i)
                                  : *reflection.MutableMessage(&message, &field),
              place + '.');
        continue;
      }
      std::string text = field.is_repeated() ? reflection.GetRepeatedString(message, &field, i)
                                             : reflection.GetString(message, &field);
      if (text.size() <= most_bytes_) continue;
      cuts_.push_back({place, text.size(), false, false});
      text.resize(most_bytes_);
      if (field.is_repeated()) {
        reflection.SetRepeatedString(&message, &field, i, std::move(text));
      } else {
        reflection.SetString(&message, &field, std::move(text));
      }
    }
  }

  const std::size_t most_elements_, kept_elements_, most_bytes_;
  std::vector<Shortened> cuts_;
};

// Says in each "name: [1, 2, 3, ...]" line that was cut how long it was. Cut ones hold one number
// more than whole ones can, which is taken away; `cuts` are in the order of the lines.
std::string with_sizes(const std::string& text, const std::vector<Shortened>& cuts) {
  std::string result, others;
  std::size_t begin = 0;
  for (const Shortened& cut : cuts) {
    if (!cut.is_numbers) {
      others += "# " + cut.field + ": the first " + std::to_string(kMostElements) + " of " +
                std::to_string(cut.size) + "\n";
      continue;
    }
    const std::string field = cut.field.substr(cut.field.rfind('.') + 1) + ": [";
    for (bool found = false; !found && begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      std::string line = text.substr(begin, end - begin);
      begin = end + 1;
      const std::size_t name = line.find_first_not_of(' ');
      found = name != std::string::npos && line.compare(name, field.size(), field) == 0 &&
              std::count(line.begin(), line.end(), ',') == kMostElements;
      if (found) {
        line.resize(line.rfind(','));
        line += ", ... " + std::to_string(cut.size) + " in all]";
      }
      result += line + '\n';
    }
  }
  return result + (begin < text.size() ? text.substr(begin) : "") + others;
}

}  // namespace

std::vector<Shortened> shorten(Message& message, std::size_t most_elements,
                               std::size_t most_bytes) {
  Shortening shortening(most_elements, most_elements, most_bytes);
  shortening.visit(message, "");
  return shortening.take();
}

std::string message_text(const Message& message, bool full) {
  TextFormat::Printer printer;
  printer.SetUseShortRepeatedPrimitives(true);
  std::string text;
  if (full) {
    printer.PrintToString(message, &text);
    return text;
  }
  const std::unique_ptr<Message> copy(message.New());
  copy->CopyFrom(message);
  Shortening shortening(kMostElements, kMostElements + 1, std::string::npos);
  shortening.visit(*copy, "");
  printer.SetDefaultFieldValuePrinter(new ElidingPrinter);  // the printer owns it
  printer.PrintToString(*copy, &text);
  return with_sizes(text, shortening.take());
}

}  // namespace prehend::tools
