#include "drivers/kuka_rsi/codec/xml_reader.h"

#include <algorithm>

namespace prehend::drivers::kuka_rsi {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
bool begins_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_of_name(char c) { return begins_name(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; }

// What text and values may not hold: control characters, and '&', with which all references begin.
const char* problem_of(std::string_view text) {
  for (const char c : text) {
    if (c == '&') return "it has an entity or a character reference";
    if (static_cast<unsigned char>(c) < 0x20 && !is_space(c)) return "it has control characters";
  }
  return nullptr;
}

}  // namespace

XmlReader::XmlReader(std::string_view text) : left_(text) {
  if (text.size() > kLongestText) wrong("it is longer than 4096 bytes");
}

XmlReader::Event XmlReader::wrong(const char* why) {
  if (*problem_ == '\0') problem_ = why;
  left_ = {};
  return Event::kWrong;
}

void XmlReader::skip_space() {
  const auto end = std::find_if_not(left_.begin(), left_.end(), is_space);
  left_.remove_prefix(static_cast<std::size_t>(end - left_.begin()));
}

std::string_view XmlReader::read_name() {
  if (left_.empty() || !begins_name(left_.front())) return {};
  const auto end = std::find_if_not(left_.begin(), left_.end(), is_of_name);
  const std::string_view name = left_.substr(0, static_cast<std::size_t>(end - left_.begin()));
  left_.remove_prefix(name.size());
  return name.size() > kLongestName ? std::string_view() : name;
}

XmlReader::Event XmlReader::next() {
  if (*problem_ != '\0') return Event::kWrong;
  if (ends_at_once_) {
    ends_at_once_ = false;
    --depth_;
    return Event::kEnd;
  }
  const std::size_t end = std::min(left_.find('<'), left_.size());
  text_ = left_.substr(0, end);
  left_.remove_prefix(end);
  if (const char* why = problem_of(text_)) return wrong(why);
  if (!std::all_of(text_.begin(), text_.end(), is_space)) {
    return depth_ > 0 ? Event::kText : wrong("it has text outside of its root element");
  }
  if (left_.empty()) {
    if (depth_ > 0) return wrong("it is cut off");
    return has_root_ ? Event::kDone : wrong("it is empty");
  }
  left_.remove_prefix(1);
  if (at('/')) return read_end();
  if (at('!') || at('?')) return wrong("it has a declaration, a comment or a document type");
  return read_start();
}

XmlReader::Event XmlReader::read_start() {
  if (depth_ == 0 && has_root_) return wrong("it has two root elements");
  if (depth_ == kMostDepth) return wrong("its elements are nested too deeply");
  name_ = read_name();
  if (name_.empty()) return wrong("an element has no right name");
  has_root_ = true;
  attribute_count_ = 0;
  while (true) {
    const std::size_t before = left_.size();
    skip_space();
    const bool had_space = left_.size() != before;
    if (at('>') || at('/')) break;
    if (!had_space) return wrong("attributes are not separated by space");
    if (!read_attribute()) return Event::kWrong;
  }
  open_[depth_++] = name_;
  ends_at_once_ = at('/');
  if (ends_at_once_) left_.remove_prefix(1);
  if (!at('>')) return wrong("a tag is not closed");
  left_.remove_prefix(1);
  return Event::kStart;
}

bool XmlReader::read_attribute() {
  const auto fails = [this](const char* why) {
    wrong(why);
    return false;
  };
  XmlAttribute attribute;
  attribute.name = read_name();
  if (attribute.name.empty()) return fails("an attribute has no right name");
  skip_space();
  if (!at('=')) return fails("an attribute has no value");
  left_.remove_prefix(1);
  skip_space();
  if (!at('"') && !at('\'')) return fails("a value is not in quotes");
  const std::size_t end = left_.find(left_.front(), 1);
  if (end == std::string_view::npos) return fails("a value's quotes are not closed");
  attribute.value = left_.substr(1, end - 1);
  left_.remove_prefix(end + 1);
  if (attribute.value.find('<') != std::string_view::npos) return fails("a value has '<'");
  if (const char* why = problem_of(attribute.value)) return fails(why);
  for (const XmlAttribute& other : attributes()) {
    if (other.name == attribute.name) return fails("an attribute is given twice");
  }
  if (attribute_count_ == kMostAttributes) return fails("an element has too many attributes");
  attributes_[attribute_count_++] = attribute;
  return true;
}

XmlReader::Event XmlReader::read_end() {
  left_.remove_prefix(1);
  name_ = read_name();
  skip_space();
  if (!at('>')) return wrong("a tag is not closed");
  left_.remove_prefix(1);
  if (depth_ == 0 || open_[depth_ - 1] != name_) return wrong("a tag closes another element");
  attribute_count_ = 0;
  --depth_;
  return Event::kEnd;
}

}  // namespace prehend::drivers::kuka_rsi
