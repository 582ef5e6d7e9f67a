#pragma once

#include <cstdint>
#include <string>

namespace prehend::tools {

/// [ns] of "10ms", "0.5s", "2min": a number of at least 0 and one of ns, us, ms, s, min, h.
/// Throws std::invalid_argument naming the units when it is not that.
std::int64_t parse_duration(const std::string& text);

/// Bytes of "500MB", "1GB", "64KiB": a number of at least 0 and one of B, kB, MB, GB, TB (powers of
/// 1000), KiB, MiB, GiB, TiB (powers of 1024). Throws std::invalid_argument when it is not that.
std::uint64_t parse_bytes(const std::string& text);

}  // namespace prehend::tools
