#pragma once

#include <string>
#include <string_view>

/// The frame of what World writes: "prehend KIND\n", version, length, payload, checksum.
namespace prehend::simulation {

/// `kind` is one word.
std::string framed(std::string_view kind, std::string_view payload);

/// The payload. @throws geometry::InputError naming `what` and the mend: bytes that are something
/// else, of another version, cut off, longer than they should be, or damaged.
std::string_view unframed(std::string_view kind, std::string_view bytes, const std::string& what);

}  // namespace prehend::simulation
