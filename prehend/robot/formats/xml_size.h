#pragma once

#include <string_view>

namespace prehend::robot::formats {

/// Looks over a document before it is parsed, since what a parser makes of it is many times larger:
/// of 64 MiB of `<a/>` gigabytes. @param file for the words
/// @throws geometry::InputError for more than a million elements and attributes, or more than 1000
/// attributes of one element (parsers compare each with all before it).
void refuse_xml_bomb(std::string_view text, std::string_view file);

}  // namespace prehend::robot::formats
