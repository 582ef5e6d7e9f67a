#pragma once

#include <filesystem>
#include <string>

#include "prehend/sweep/results.h"

namespace prehend::sweep {

/// The figures that a program left in `folder` and in its `output` (a file). @throws InputError in
/// words when they are not there or cannot be read.
Rows collect(const ResultSource& source, const std::filesystem::path& folder,
             const std::filesystem::path& output);

/// The last lines of a file, at most 20 and 4 kB; empty when there is none.
std::string last_lines(const std::filesystem::path& file);

}  // namespace prehend::sweep
