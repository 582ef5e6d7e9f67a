#pragma once

#include <string>

namespace prehend::report {

/// `text` with what HTML and SVG take for markup replaced by its entities.
std::string escaped(const std::string& text);

}  // namespace prehend::report
