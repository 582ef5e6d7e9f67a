#pragma once

#include <filesystem>
#include <string>

#include "eval/touch/tradeoff.h"

namespace prehend::eval::touch {

/// Writes the fronts as YAML into the folder `fronts`, and a page with charts and all that was
/// measured (also as CSV) into the folder `out`; both exist. `machine`: on which it was measured.
/// @throws geometry::InputError for a file that cannot be written.
void write_touch_tradeoff(const TouchTradeoff& tradeoff, const std::string& machine,
                          const std::filesystem::path& fronts, const std::filesystem::path& out);

}  // namespace prehend::eval::touch
