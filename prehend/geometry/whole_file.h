#pragma once

#include <filesystem>
#include <string>

namespace prehend::geometry {

/// Writes `text` and a line's end to `file` so that it is there whole or not at all, however the
/// process ends: into a file beside it, which then takes its name. `what` names it in errors, as
/// in "The front".
/// @throws InputError when it cannot be written; the old file is as it was.
void write_whole_file(const std::filesystem::path& file, const std::string& text,
                      const std::string& what);

}  // namespace prehend::geometry
