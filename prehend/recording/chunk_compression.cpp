#include "prehend/recording/chunk_compression.h"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "prehend/recording/mcap_records.h"

namespace prehend::recording {
namespace {

constexpr std::uint64_t kFirstBuffer = 4 * 1024 * 1024;

// Grows `out` (twofold, at most to `limit`) once its `used` bytes fill it; false at the limit.
bool make_room(std::string& out, std::size_t used, std::uint64_t limit) {
  if (used < out.size()) return true;
  if (out.size() >= limit) return false;
  out.resize(std::min<std::uint64_t>(limit, out.size() * 2));
  return true;
}

[[noreturn]] void throw_size_mismatch(std::uint64_t declared) {
  throw McapError("the chunk does not unpack to the " + std::to_string(declared) +
                  " bytes it declares");
}

std::string decompress_lz4(std::string_view bytes, std::uint64_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, LZ4F_freeDecompressionContext);
  std::string out(std::min(size, kFirstBuffer) + 1, '\0');  // one byte more shows an overlong frame
  std::size_t used = 0, wanted = 1;
  while (wanted != 0) {
    if (!make_room(out, used, size + 1)) throw_size_mismatch(size);
    std::size_t produced = out.size() - used, consumed = bytes.size();
    wanted = LZ4F_decompress(context.get(), out.data() + used, &produced, bytes.data(), &consumed,
                             nullptr);
    if (LZ4F_isError(wanted)) {
      throw McapError(std::string("LZ4 data is damaged: ") + LZ4F_getErrorName(wanted));
    }
    used += produced;
    bytes.remove_prefix(consumed);
    if (wanted != 0 && produced == 0 && consumed == 0) throw McapError("LZ4 data is cut off");
  }
  if (used != size) throw_size_mismatch(size);
  out.resize(used);
  return out;
}

std::string decompress_zstd(std::string_view bytes, std::uint64_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  std::string out(std::min(size, kFirstBuffer) + 1, '\0');
  ZSTD_inBuffer input{bytes.data(), bytes.size(), 0};
  std::size_t used = 0, wanted = 1;
  while (wanted != 0) {
    if (!make_room(out, used, size + 1)) throw_size_mismatch(size);
    ZSTD_outBuffer output{out.data(), out.size(), used};
    const std::size_t consumed_before = input.pos;
    wanted = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(wanted)) {
      throw McapError(std::string("zstd data is damaged: ") + ZSTD_getErrorName(wanted));
    }
    const bool stuck = output.pos == used && input.pos == consumed_before;
    used = output.pos;
    if (wanted != 0 && stuck) throw McapError("zstd data is cut off");
  }
  if (used != size) throw_size_mismatch(size);
  out.resize(used);
  return out;
}

}  // namespace

std::string compress_lz4(std::string_view bytes) {
  std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  const std::size_t size =
      LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
  if (LZ4F_isError(size)) {
    throw McapError(std::string("LZ4 compression failed: ") + LZ4F_getErrorName(size));
  }
  out.resize(size);
  return out;
}

std::string compress_zstd(std::string_view bytes, int level) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), level);
  if (ZSTD_isError(size)) {
    throw McapError(std::string("zstd compression failed: ") + ZSTD_getErrorName(size));
  }
  out.resize(size);
  return out;
}

std::string decompress(std::string_view compression, std::string bytes,
                       std::uint64_t uncompressed_size) {
  if (compression == "lz4") return decompress_lz4(bytes, uncompressed_size);
  if (compression == "zstd") return decompress_zstd(bytes, uncompressed_size);
  if (!compression.empty()) {
    throw McapError("unknown compression \"" + std::string(compression.substr(0, 32)) + "\"");
  }
  if (bytes.size() != uncompressed_size) throw_size_mismatch(uncompressed_size);
  return bytes;
}

}  // namespace prehend::recording
