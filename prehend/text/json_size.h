#pragma once

#include <string>

namespace prehend::text {

/// Looks a text over before it becomes values, which are many times larger: of 64 MiB of brackets
/// gigabytes. @param file for the words
/// @throws InputError for more than two million values, an object of more than 10,000 keys, a key
/// twice in one object, of which readers take one or the other, and more than 32 levels. What is no
/// JSON is left to its reader.
void refuse_json_bomb(const std::string& text, const std::string& file);

}  // namespace prehend::text
