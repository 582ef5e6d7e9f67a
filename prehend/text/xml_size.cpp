#include "prehend/text/xml_size.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

constexpr std::size_t kMostParts = 1000000;  // a hand of many meshes has some 20,000
constexpr std::size_t kMostAttributes = 1000;
constexpr std::size_t kDeepestElement = 100;  // as tinyxml2 has it

/// Where what is at `begin` ends: behind the next `end`, or at the end of all.
std::size_t behind(std::string_view text, std::string_view end, std::size_t begin) {
  const std::size_t at = text.find(end, begin);
  return at == std::string_view::npos ? text.size() : at + end.size();
}

/// Behind what begins at `at` and is no element's tag, as TinyXML has it, whose limits are these
/// alone; `at` itself: it is one.
std::size_t behind_other(std::string_view text, std::size_t at) {
  for (const auto& [begin, end] :
       {std::pair<std::string_view, std::string_view>("<!--", "-->"),
        std::pair<std::string_view, std::string_view>("<![CDATA[", "]]>")}) {
    if (text.substr(at).starts_with(begin)) return behind(text, end, at + begin.size());
  }
  const auto first = static_cast<unsigned char>(at + 1 < text.size() ? text[at + 1] : '!');
  const bool is_tag = std::isalpha(first) != 0 || first == '_' || first == '/' || first > 126;
  return is_tag ? at : behind(text, ">", at);
}

}  // namespace

void refuse_xml_bomb(std::string_view text, std::string_view file) {
  const auto refuse = [&](const char* what) {
    throw InputError(std::string(file) + " has " + what + ": no file of a robot or a mesh",
                     "Check the path");
  };
  std::size_t parts = 0, depth = 0;
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    if (const std::size_t next = behind_other(text, at); next != at) {
      at = next;
      continue;
    }
    // A tag: an equals sign that is not within quotes is an attribute's.
    const bool is_end = text[at + 1] == '/';
    std::size_t attributes = 0;
    for (++at; at < text.size() && text[at] != '>'; ++at) {
      if (text[at] == '=') ++attributes;
      if (text[at] == '"' || text[at] == '\'')
        at = std::min(text.find(text[at], at + 1), text.size());
      if (at >= text.size()) break;
    }
    parts += 1 + attributes;
    if (parts > kMostParts) refuse("more than a million elements and attributes");
    if (attributes > kMostAttributes) refuse("an element of more than 1000 attributes");
    if (is_end) {
      depth -= std::min<std::size_t>(depth, 1);
    } else if (text[std::min(at, text.size()) - 1] != '/' && ++depth > kDeepestElement) {
      refuse("elements nested deeper than 100");
    }
  }
}

}  // namespace prehend::text
