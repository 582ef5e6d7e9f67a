#pragma once

#include <string>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {

/// What `find` returns. An InputError of it (a name that is not there) becomes one at the line of
/// `key` of `map`, with the same mend.
template <class Find>
auto at_line(const text::YamlMap& map, const std::string& key, Find find) -> decltype(find()) {
  try {
    return find();
  } catch (const geometry::InputError& error) {
    // what() is "problem. mend."
    std::string mend = std::string(error.what()).substr(error.problem().size() + 2);
    mend.pop_back();
    map.fail(key, ": " + error.problem(), mend);
  }
}

}  // namespace prehend::robot
