#include "tools/said_outcome.h"

#include <google/protobuf/descriptor.h>

#include <string>

namespace prehend::tools {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

const FieldDescriptor* field_of(const Message& message, const char* name,
                                FieldDescriptor::CppType type) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
  return field && !field->is_repeated() && field->cpp_type() == type ? field : nullptr;
}

const FieldDescriptor* flag_of(const Message& message, const char* name) {
  return field_of(message, name, FieldDescriptor::CPPTYPE_BOOL);
}

bool is_set(const Message& message, const char* name) {
  const FieldDescriptor* field = flag_of(message, name);
  return field && message.GetReflection()->GetBool(message, field);
}

std::string text_of(const Message& message, const char* name) {
  const FieldDescriptor* field = field_of(message, name, FieldDescriptor::CPPTYPE_STRING);
  return field ? message.GetReflection()->GetString(message, field) : "";
}

}  // namespace

SaidOutcome said_outcome(const Message& answer) {
  if (const std::string error = text_of(answer, "error"); !error.empty()) return {false, error};
  const bool says = flag_of(answer, "success") || flag_of(answer, "reached");
  const bool ended = is_set(answer, "success") || is_set(answer, "reached") ||
                     is_set(answer, "contact") || is_set(answer, "blocked");
  if (!says || ended) return {};
  const std::string reason = text_of(answer, "reason");
  return {false, reason.empty() ? "without a reason" : reason};
}

}  // namespace prehend::tools
