#pragma once

#include <stdexcept>
#include <string>

namespace YAML {
class Node;
}

namespace prehend::text {

/// A YAML text is refused. what() is "FILE:LINE: what is wrong and how to mend it".
class YamlError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Reads YAML as people mean it and nothing else: at most 1 MiB of UTF-8 without control
/// characters, one document, nested at most 32 deep, at most 20000 values after aliases are put in,
/// no key twice in a mapping, keys that are plain text, no anchor that holds itself, no tags.
/// Throws YamlError. An empty file gives a null node.
YAML::Node load_strict_yaml(const std::string& file);

/// The same for a text that is already read; `file` names it in messages.
YAML::Node parse_strict_yaml(const std::string& text, const std::string& file);

}  // namespace prehend::text
