#include "tools/json.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace prehend::tools {
namespace {

// Length of the well-formed UTF-8 sequence that `text` begins with, 0: none.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xC2 && first < 0xE0 ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  if (length < 3) return length;
  const unsigned char second = byte(1);  // overlong forms, surrogates, beyond U+10FFFF
  const bool wrong = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                     (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
  return wrong ? 0 : length;
}

std::string json_quoted(std::string_view text) {
  std::string result = "\"";
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const unsigned char first = static_cast<unsigned char>(text[0]);
    if (length == 0) {
      result += "\\ufffd";
    } else if (first == '"' || first == '\\') {
      result += {'\\', text[0]};
    } else if (first < 0x20) {
      result += fmt::format("\\u{:04x}", first);
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result + '"';
}

}  // namespace

Json Json::null() {
  Json result(char{0});
  result.body_ = "null";
  return result;
}

Json Json::of(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  Json result(char{0});
  const auto status = google::protobuf::util::MessageToJsonString(message, &result.body_, options);
  if (!status.ok()) {
    throw std::runtime_error("a " + message.GetTypeName() +
                             " cannot be said in JSON: " + status.ToString());
  }
  return result;
}

Json::Json(std::string_view text) : body_(json_quoted(text)) {}
Json::Json(bool value) : body_(value ? "true" : "false") {}
Json::Json(double value) : body_(std::isfinite(value) ? fmt::format("{}", value) : "null") {}

Json::Json(const std::vector<std::string>& texts) : open_('[') {
  for (const std::string& text : texts) add(text);
}

void Json::begin_entry() {
  if (!body_.empty()) body_ += ',';
}

Json& Json::set(std::string_view name, const Json& value) {
  if (open_ != '{') throw std::logic_error("only JSON objects have members");
  begin_entry();
  body_ += json_quoted(name) + ':' + value.text();
  return *this;
}

Json& Json::add(const Json& value) {
  if (open_ != '[') throw std::logic_error("only JSON arrays have elements");
  begin_entry();
  body_ += value.text();
  return *this;
}

std::string Json::text() const {
  if (open_ == 0) return body_;
  return open_ + body_ + (open_ == '{' ? '}' : ']');
}

void print(const Json& json) {
  std::printf("%s\n", json.text().c_str());
  std::fflush(stdout);
}

}  // namespace prehend::tools
