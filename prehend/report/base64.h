#pragma once

#include <string>

namespace prehend::report {

/// RFC 4648, section 4.
std::string base64(const std::string& bytes);

}  // namespace prehend::report
