#include "tools/bag_export/field_columns.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>

namespace prehend::tools {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using Visit = std::function<void(const FieldPlace&, const std::string&, std::string)>;

constexpr int kMostRepeated = 1000;
constexpr std::size_t kDeepest = 20;  // parts within parts

// `index` -1: not repeated.
std::string value_text(const Message& message, const FieldDescriptor& field, int index) {
  const auto& reflection = *message.GetReflection();
  const auto* f = &field;
  const bool one = index < 0;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return fmt::to_string(one ? reflection.GetInt32(message, f)
                                : reflection.GetRepeatedInt32(message, f, index));
    case FieldDescriptor::CPPTYPE_INT64:
      return fmt::to_string(one ? reflection.GetInt64(message, f)
                                : reflection.GetRepeatedInt64(message, f, index));
    case FieldDescriptor::CPPTYPE_UINT32:
      return fmt::to_string(one ? reflection.GetUInt32(message, f)
                                : reflection.GetRepeatedUInt32(message, f, index));
    case FieldDescriptor::CPPTYPE_UINT64:
      return fmt::to_string(one ? reflection.GetUInt64(message, f)
                                : reflection.GetRepeatedUInt64(message, f, index));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return fmt::format("{}", one ? reflection.GetDouble(message, f)
                                   : reflection.GetRepeatedDouble(message, f, index));
    case FieldDescriptor::CPPTYPE_FLOAT:
      return fmt::format("{}", one ? reflection.GetFloat(message, f)
                                   : reflection.GetRepeatedFloat(message, f, index));
    case FieldDescriptor::CPPTYPE_BOOL:
      return (one ? reflection.GetBool(message, f) : reflection.GetRepeatedBool(message, f, index))
                 ? "true"
                 : "false";
    case FieldDescriptor::CPPTYPE_ENUM: {
      const int number = one ? reflection.GetEnumValue(message, f)
                             : reflection.GetRepeatedEnumValue(message, f, index);
      const auto* value = field.enum_type()->FindValueByNumber(number);
      return value ? value->name() : fmt::to_string(number);
    }
    case FieldDescriptor::CPPTYPE_STRING:
      return one ? reflection.GetString(message, f)
                 : reflection.GetRepeatedString(message, f, index);
    case FieldDescriptor::CPPTYPE_MESSAGE:
      break;
  }
  return "";
}

void visit_message(const Message& message, FieldPlace& place, const std::string& prefix,
                   const Visit& visit);

void visit_value(const Message& message, const FieldDescriptor& field, int index, FieldPlace& place,
                 const std::string& name, const Visit& visit) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    const auto& reflection = *message.GetReflection();
    const Message& part = index < 0 ? reflection.GetMessage(message, &field)
                                    : reflection.GetRepeatedMessage(message, &field, index);
    visit_message(part, place, name + ".", visit);
  } else if (field.type() == FieldDescriptor::TYPE_BYTES) {
    visit(place, name + ".size", fmt::to_string(value_text(message, field, index).size()));
  } else {
    visit(place, name, value_text(message, field, index));
  }
}

void visit_message(const Message& message, FieldPlace& place, const std::string& prefix,
                   const Visit& visit) {
  if (place.size() > kDeepest) return;
  const auto& reflection = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    const std::string name = prefix + field.name();
    place.push_back(field.number());
    if (field.is_repeated()) {
      const int count = std::min(reflection.FieldSize(message, &field), kMostRepeated);
      for (int index = 0; index < count; ++index) {
        place.push_back(index);
        visit_value(message, field, index, place, fmt::format("{}[{}]", name, index), visit);
        place.pop_back();
      }
    } else if (!field.has_presence() || reflection.HasField(message, &field)) {
      visit_value(message, field, -1, place, name, visit);
    }
    place.pop_back();
  }
}

std::string csv(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  quoted += '"';
  return quoted;
}

}  // namespace

void visit_scalars(const Message& message, const Visit& visit) {
  FieldPlace place;
  visit_message(message, place, "", visit);
}

void FieldColumns::add(const Message& message) {
  visit_scalars(message, [this](const FieldPlace& place, const std::string& name, std::string) {
    names_.try_emplace(place, name);
  });
}

std::string FieldColumns::header() const {
  std::string line;
  for (const auto& [place, name] : names_) line.append(1, ',').append(csv(name));
  return line;
}

std::string FieldColumns::row(const Message& message) const {
  std::map<FieldPlace, std::string> values;
  visit_scalars(message, [&](const FieldPlace& place, const std::string&, std::string value) {
    values.emplace(place, std::move(value));
  });
  std::string line;
  for (const auto& [place, name] : names_) {
    const auto value = values.find(place);
    line += ',';
    if (value != values.end()) line += csv(value->second);
  }
  return line;
}

}  // namespace prehend::tools
