#include "prehend/text/json.h"

#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

namespace prehend::text {
namespace {

// Of nlohmann's text and numbers; NaN and infinities are null there.
template <typename Value>
std::string dumped(const Value& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

Json Json::said(std::string json) {
  Json result(char{0});
  result.body_ = std::move(json);
  return result;
}

Json::Json(std::string_view text) : body_(dumped(text)) {}
Json::Json(bool value) : body_(value ? "true" : "false") {}
Json::Json(double value) : body_(dumped(value)) {}

Json::Json(const std::vector<std::string>& texts) : open_('[') {
  for (const std::string& text : texts) add(text);
}

void Json::begin_entry() {
  if (!body_.empty()) body_ += ',';
}

Json& Json::set(std::string_view name, const Json& value) {
  if (open_ != '{') throw std::logic_error("only JSON objects have members");
  begin_entry();
  body_ += dumped(name) + ':' + value.text();
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

std::string Json::pretty() const { return nlohmann::ordered_json::parse(text()).dump(1) + '\n'; }

}  // namespace prehend::text
