#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace prehend::text {

/// One JSON value (RFC 8259), built piece by piece; members stand in the order they were added.
/// Text that is no UTF-8 gets U+FFFD in its place, numbers that JSON cannot say become null.
class Json {
 public:
  static Json object() { return Json('{'); }
  static Json array() { return Json('['); }
  static Json null() { return said("null"); }
  /// What is JSON already. It is not checked.
  static Json said(std::string json);
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

  /// @throws std::logic_error when it is no object.
  Json& set(std::string_view name, const Json& value);
  /// @throws std::logic_error when it is no array.
  Json& add(const Json& value);
  /// On one line.
  std::string text() const;
  /// Over several lines, each level a space further in, with a line's end; for files.
  std::string pretty() const;

 private:
  explicit Json(char open) : open_(open) {}
  void begin_entry();

  char open_ = 0;
  std::string body_;
};

}  // namespace prehend::text
