#pragma once

#include <cstddef>
#include <filesystem>

namespace prehend::robot::formats {

/// The compiler's time is as their square: 0.3 s for so many, 6 s for five times as many.
inline constexpr std::size_t kMostMjcfBodies = 2000;

/// Looks over an MJCF and all that it includes before MuJoCo's compiler reads them, which takes
/// memory and time by the words of a file, ends the program where memory ends, and waits for a pipe
/// in place of a mesh.
/// @throws geometry::InputError for more than kMostMjcfBodies, also of composites and of parts
/// that are repeated; for fields, textures and user's numbers of more memory than a robot has; for
/// includes in a ring; for assets that are no files
void refuse_mjcf_bomb(const std::filesystem::path& file);

}  // namespace prehend::robot::formats
