#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace prehend::recording {

/// One LZ4 frame, or one Zstandard frame at `level`. Throws McapError when the library fails.
std::string compress_lz4(std::string_view bytes);
std::string compress_zstd(std::string_view bytes, int level);

/// Undoes the compression that the Chunk record names ("", "lz4", "zstd"). The output grows with
/// what really comes out, so a false `uncompressed_size` costs no memory. Throws McapError when the
/// compression is unknown, the data is damaged, or it does not give exactly `uncompressed_size`.
std::string decompress(std::string_view compression, std::string bytes,
                       std::uint64_t uncompressed_size);

}  // namespace prehend::recording
