#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

/// One JSON value, built piece by piece; members stand in the order they were added. Text that is
/// no UTF-8 gets U+FFFD in its place, numbers that JSON cannot say become null.
class Json {
 public:
  static Json object() { return Json('{'); }
  static Json array() { return Json('['); }
  static Json null();
  /// Protobuf's own JSON, with the field names of the .proto file and fields at their defaults,
  /// too.
  static Json of(const google::protobuf::Message& message);
  /// Time stamps do not fit a double, so they are text, as in protobuf's JSON.
  static Json stamp(std::int64_t nanoseconds) { return Json(std::to_string(nanoseconds)); }

  Json(std::string_view text);
  Json(const std::string& text) : Json(std::string_view(text)) {}
  Json(const char* text) : Json(std::string_view(text)) {}
  Json(bool value);
  Json(double value);
  template <std::integral Integer>
  Json(Integer value) : body_(std::to_string(value)) {}
  Json(const std::vector<std::string>& texts);

  Json& set(std::string_view name, const Json& value);
  Json& add(const Json& value);
  /// On one line.
  std::string text() const;

 private:
  explicit Json(char open) : open_(open) {}
  void begin_entry();

  char open_ = 0;
  std::string body_;
};

/// Prints it and a line's end, at once.
void print(const Json& json);

}  // namespace prehend::tools
