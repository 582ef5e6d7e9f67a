#include "prehend/robot/formats/xml_size.h"

#include <algorithm>
#include <string>

#include "prehend/geometry/errors.h"

namespace prehend::robot::formats {
namespace {

constexpr std::size_t kMostParts = 1000000;  // a hand of many meshes has some 20,000
constexpr std::size_t kMostAttributes = 1000;

/// Where what begins at `begin` ends: behind `end`, or at the end of all.
std::size_t behind(std::string_view text, std::string_view end, std::size_t begin) {
  const std::size_t at = text.find(end, begin);
  return at == std::string_view::npos ? text.size() : at + end.size();
}

}  // namespace

void refuse_xml_bomb(std::string_view text, std::string_view file) {
  std::size_t parts = 0;
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--")) {
      at = behind(text, "-->", at);
      continue;
    }
    if (rest.starts_with("<![CDATA[")) {
      at = behind(text, "]]>", at);
      continue;
    }
    if (rest.starts_with("<?")) {
      at = behind(text, "?>", at);
      continue;
    }
    // A tag: an equals sign that is not within quotes is an attribute's.
    std::size_t attributes = 0;
    for (++at; at < text.size() && text[at] != '>'; ++at) {
      if (text[at] == '=') ++attributes;
      if (text[at] == '"' || text[at] == '\'')
        at = std::min(text.find(text[at], at + 1), text.size());
      if (at >= text.size()) break;
    }
    parts += 1 + attributes;
    if (parts <= kMostParts && attributes <= kMostAttributes) continue;
    throw geometry::InputError(
        std::string(file) +
            (parts > kMostParts ? " has more than a million elements and attributes"
                                : " has an element of more than 1000 attributes") +
            ": no robot's file",
        "Check the path");
  }
}

}  // namespace prehend::robot::formats
