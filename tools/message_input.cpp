#include "tools/message_input.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <regex>
#include <set>
#include <stdexcept>
#include <vector>

#include "prehend/text/nearest_match.h"

namespace prehend::tools {
namespace {

namespace pb = google::protobuf;
using text::nearest_match_hint;

// The message types and enumerations that a message can hold, itself the first.
struct Reachable {
  explicit Reachable(const pb::Descriptor& type) { add(type); }
  void add(const pb::Descriptor& type) {
    if (!seen.insert(&type).second) return;
    types.push_back(&type);
    for (int i = 0; i < type.field_count(); ++i) {
      if (type.field(i)->message_type()) add(*type.field(i)->message_type());
    }
  }
  const pb::Descriptor* type_named(const std::string& full_name) const {
    for (const auto* type : types) {
      if (type->full_name() == full_name) return type;
    }
    return nullptr;
  }
  std::set<const pb::Descriptor*> seen;
  std::vector<const pb::Descriptor*> types;
};

std::vector<std::string> fields_of(const pb::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  return names;
}

std::vector<std::string> values_of(const pb::EnumDescriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i) names.push_back(type.value(i)->name());
  return names;
}

// The type of the field that `path` ("pose.points[2].x") names in a message of type `type`.
const pb::FieldDescriptor* field_at(const pb::Descriptor& type, const std::string& path) {
  const pb::Descriptor* at = &type;
  const pb::FieldDescriptor* field = nullptr;
  for (std::size_t begin = 0; at != nullptr && begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    std::string name = path.substr(begin, end - begin);
    name = name.substr(0, name.find('['));
    field = at->FindFieldByName(name);
    if (!field) field = at->FindFieldByCamelcaseName(name);
    if (!field) return nullptr;
    at = field->message_type();
    begin = end + 1;
  }
  return field;
}

// What was probably meant, where protobuf's words on text show it.
std::string hint_for_text(const std::string& words, const pb::Descriptor& type) {
  static const std::regex kNoField("Message type \"([^\"]*)\" has no field named \"([^\"]*)\".*");
  static const std::regex kNoValue(
      "Unknown enumeration value of \"([^\"]*)\" for field \"([^\"]*)\".*");
  const Reachable reachable(type);
  std::smatch match;
  if (std::regex_match(words, match, kNoField)) {
    const auto* holder = reachable.type_named(match[1]);
    return holder ? text::nearest_match_hint(match[2].str(), fields_of(*holder)) : "";
  }
  if (!std::regex_match(words, match, kNoValue)) return "";
  for (const auto* holder : reachable.types) {
    const auto* field = holder->FindFieldByName(match[2]);
    if (field && field->enum_type()) {
      return text::nearest_match_hint(match[1].str(), values_of(*field->enum_type()));
    }
  }
  return "";
}

// The same for protobuf's words on JSON: "(pose.point[0]) xx: Cannot find field.",
// "(mode): invalid value "X" for type ...".
std::string hint_for_json(const std::string& words, const pb::Descriptor& type) {
  static const std::regex kNoField("(?:\\(([^)]*)\\) )?([^ :]+): Cannot find field\\.[\\s\\S]*");
  static const std::regex kNoValue("\\(([^)]*)\\): invalid value \"([^\"]*)\"[\\s\\S]*");
  std::smatch match;
  if (std::regex_match(words, match, kNoField)) {
    const auto* field = match[1].matched ? field_at(type, match[1]) : nullptr;
    const auto* holder = field ? field->message_type() : match[1].matched ? nullptr : &type;
    return holder ? text::nearest_match_hint(match[2].str(), fields_of(*holder)) : "";
  }
  if (!std::regex_match(words, match, kNoValue)) return "";
  const auto* field = field_at(type, match[1]);
  return field && field->enum_type()
             ? text::nearest_match_hint(match[2].str(), values_of(*field->enum_type()))
             : "";
}

class FirstError : public pb::io::ErrorCollector {
 public:
  void AddError(int line, pb::io::ColumnNumber column, const std::string& words) override {
    if (!text.empty()) return;
    text = words;
    place = fmt::format("line {}, column {}", line + 1, column + 1);
  }
  std::string text, place;
};

void parse_text(const std::string& text, pb::Message& message) {
  FirstError error;
  pb::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  if (parser.ParseFromString(text, &message)) return;
  while (!error.text.empty() && error.text.back() == '.') error.text.pop_back();
  throw std::runtime_error(fmt::format("the text is no {}: {}: {}{}", message.GetTypeName(),
                                       error.place, error.text,
                                       hint_for_text(error.text, *message.GetDescriptor())));
}

void parse_json(const std::string& text, pb::Message& message) {
  const auto status = pb::util::JsonStringToMessage(text, &message);
  if (status.ok()) return;
  const std::string words(status.message());
  std::string line = words.substr(0, words.find('\n'));
  while (!line.empty() && line.back() == '.') line.pop_back();
  throw std::runtime_error(fmt::format("the JSON is no {}: {}{}", message.GetTypeName(), line,
                                       hint_for_json(words, *message.GetDescriptor())));
}

}  // namespace

void parse_message(const std::string& text, pb::Message& message) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin != std::string::npos && text[begin] == '{') return parse_json(text, message);
  parse_text(text, message);
}

}  // namespace prehend::tools
