#pragma once

#include <string_view>

namespace prehend::text {

/// Looks over a document before it is parsed, since what a parser makes of it is many times larger:
/// of 64 MiB of `<a/>` gigabytes; and some call themselves for each level, down to the stack's end.
/// @param file for the words
/// @throws InputError for more than a million elements and attributes, more than 1000 attributes of
/// one element (parsers compare each with all before it), or elements more than 100 deep.
void refuse_xml_bomb(std::string_view text, std::string_view file);

}  // namespace prehend::text
