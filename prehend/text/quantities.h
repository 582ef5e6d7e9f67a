#pragma once

#include <cstdint>
#include <string>

namespace prehend::text {

/// Numbers with a unit, as people type them: "10ms", "0.5 s". All throw InputError naming the units
/// when the text is anything else.

/// [ns], at least 0, of ns, us, ms, s, min, h.
std::int64_t parse_duration(const std::string& text);

/// Bytes, at least 0, of B, kB, MB, GB, TB (powers of 1000), KiB, MiB, GiB, TiB (powers of 1024).
std::uint64_t parse_bytes(const std::string& text);

/// [s], above 0, of ns, us, ms, s, min, h, or a bare number: of s.
double parse_seconds(const std::string& text);

/// [m], above 0, of um, mm, cm, m, or a bare number: of m.
double parse_metres(const std::string& text);

}  // namespace prehend::text
