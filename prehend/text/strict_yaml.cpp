#include "prehend/text/strict_yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

namespace prehend::text {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;
constexpr std::size_t kDeepest = 32;
constexpr std::size_t kMostValues = 20000;
// Brackets are counted before yaml-cpp sees them, which recurses into them.
constexpr std::size_t kDeepestBrackets = 4 * kDeepest;

[[noreturn]] void refuse(const std::string& file, int line, const std::string& text) {
  throw YamlError(fmt::format("{}:{}: {}", file, line, text));
}

// Length of the UTF-8 character at `at`, 0 when there is none.
std::size_t character_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u;
  };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF && follows(1)) return 2;
  if ((first & 0xF0u) == 0xE0 && follows(1) && follows(2)) {
    const bool overlong = first == 0xE0 && byte(1) < 0xA0;
    const bool surrogate = first == 0xED && byte(1) > 0x9F;
    return overlong || surrogate ? 0 : 3;
  }
  if (first >= 0xF0 && first <= 0xF4 && follows(1) && follows(2) && follows(3)) {
    const bool overlong = first == 0xF0 && byte(1) < 0x90;
    const bool beyond = first == 0xF4 && byte(1) > 0x8F;
    return overlong || beyond ? 0 : 4;
  }
  return 0;
}

void check_characters(const std::string& text, const std::string& file) {
  int line = 1;
  bool in_indentation = true;
  std::size_t brackets = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character_length(text, at);
    const auto c = static_cast<unsigned char>(text[at]);
    if (length == 0) {
      refuse(file, line, fmt::format("byte 0x{:02x} is not UTF-8; save the file as UTF-8", c));
    }
    if (c == '\t' && in_indentation) {
      refuse(file, line, "a tab indents this line; YAML indents with spaces only");
    }
    if ((c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7f) {
      refuse(file, line, fmt::format("control character 0x{:02x}; remove it", c));
    }
    if (c == '[' || c == '{') ++brackets;
    if ((c == ']' || c == '}') && brackets > 0) --brackets;
    if (brackets > kDeepestBrackets) refuse(file, line, "brackets are nested too deep");
    if (c != ' ') in_indentation = c == '\n';
    if (c == '\n') ++line;
    at += length;
  }
}

// Sees the file as events before anything is built from it.
class Inspector : public YAML::EventHandler {
 public:
  explicit Inspector(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    take_value(mark, std::nullopt, 1);
    if (anchor != 0) sizes_[anchor] = 1;
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto size = sizes_.find(anchor);
    if (size == sizes_.end()) fail(mark, "an alias stands inside what it is an alias of");
    take_value(mark, std::nullopt, size->second);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check_tag(mark, tag);
    if (value.find('\0') != std::string::npos) fail(mark, "a NUL byte in a text; remove it");
    take_value(mark, value, 1);
    if (anchor != 0) sizes_[anchor] = 1;
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    begin(mark, tag, anchor, false);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    begin(mark, tag, anchor, true);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapEnd() override { end(); }

 private:
  struct Level {
    bool is_map = false;
    bool key_is_next = true;  // of a map
    std::map<std::string, int> key_lines;
    YAML::anchor_t anchor = 0;
    std::size_t values_before = 0;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& text) const {
    refuse(file_, mark.line + 1, text);
  }

  void check_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (tag.empty() || tag == "?" || tag == "!") return;
    fail(mark, "the tag " + tag + " means nothing here; remove it");
  }

  // `text`: of a scalar; `size`: how many values it stands for.
  void take_value(const YAML::Mark& mark, const std::optional<std::string>& text,
                  std::size_t size) {
    values_ += size;
    if (values_ > kMostValues) {
      fail(mark, fmt::format("more than {} values, aliases put in", kMostValues));
    }
    if (levels_.empty() || !levels_.back().is_map) return;
    Level& map = levels_.back();
    map.key_is_next = !map.key_is_next;
    if (map.key_is_next) return;  // it was a value
    if (!text || text->empty()) fail(mark, "a key must be plain text");
    const auto [other, is_new] = map.key_lines.emplace(*text, mark.line + 1);
    if (!is_new) {
      fail(mark,
           fmt::format("the key \"{}\" is already in line {}; keep one", *text, other->second));
    }
  }

  void begin(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, bool is_map) {
    check_tag(mark, tag);
    take_value(mark, std::nullopt, 1);
    if (levels_.size() == kDeepest) {
      fail(mark, fmt::format("nested more than {} deep", kDeepest));
    }
    Level level;
    level.is_map = is_map;
    level.anchor = anchor;
    level.values_before = values_ - 1;
    levels_.push_back(std::move(level));
  }

  void end() {
    const Level& level = levels_.back();
    if (level.anchor != 0) sizes_[level.anchor] = values_ - level.values_before;
    levels_.pop_back();
  }

  const std::string file_;
  std::vector<Level> levels_;
  std::map<YAML::anchor_t, std::size_t> sizes_;  // of complete anchored values
  std::size_t values_ = 0;
};

std::string read_file(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw YamlError(file + ": there is no such file");
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw YamlError(file + ": cannot be read");
  std::string text(kMostBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

}  // namespace

YAML::Node parse_strict_yaml(const std::string& text, const std::string& file) {
  if (text.size() > kMostBytes) {
    throw YamlError(
        fmt::format("{}:1: larger than {} KiB; is this the right file?", file, kMostBytes >> 10));
  }
  check_characters(text, file);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Inspector inspector(file);
    parser.HandleNextDocument(inspector);
    Inspector second(file);
    if (parser.HandleNextDocument(second)) {
      throw YamlError(file + ": holds more than one document; remove all after the line ---");
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    refuse(file, std::max(0, error.mark.line) + 1, error.msg);
  }
}

YAML::Node load_strict_yaml(const std::string& file) {
  return parse_strict_yaml(read_file(file), file);
}

}  // namespace prehend::text
