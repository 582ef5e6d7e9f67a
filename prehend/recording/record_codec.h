#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/recording/mcap_records.h"

// How MCAP records are laid out in bytes; used by the writer and the reader only.
namespace prehend::recording {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t kRecordPrefix = 9;  // opcode and content length
constexpr std::uint64_t kFooterBytes = 29;  // the whole Footer record

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// CRC-32 as in zlib, continuing from `crc`.
std::uint32_t crc32_of(std::string_view bytes, std::uint32_t crc = 0);

/// Appends little-endian fields to `out`.
class FieldWriter {
 public:
  explicit FieldWriter(std::string& out) : out_(out) {}
  void u8(std::uint8_t value) { number(value, 1); }
  void u16(std::uint16_t value) { number(value, 2); }
  void u32(std::uint32_t value) { number(value, 4); }
  void u64(std::uint64_t value) { number(value, 8); }
  /// With a u32 length; throws McapError above 4 GiB.
  void text(std::string_view value);
  void text_map(const std::map<std::string, std::string>& values);
  /// channel -> value, as in ChunkIndex and Statistics.
  void channel_map(const std::map<std::uint16_t, std::uint64_t>& values);

 private:
  void number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out_.push_back(static_cast<char>(value >> (8 * i)));
  }
  std::string& out_;
};

/// Takes little-endian fields from `bytes`; throws McapError when a field runs past the end.
/// Allocates nothing beyond what is really there.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : bytes_(bytes) {}
  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  std::string_view raw(std::uint64_t count);
  std::string text() { return std::string(raw(u32())); }
  std::map<std::string, std::string> text_map();
  std::map<std::uint16_t, std::uint64_t> channel_map();
  std::string_view rest() const { return bytes_; }

 private:
  std::uint64_t number(std::size_t count);
  std::string_view bytes_;
};

/// Appends opcode, length and content.
void append_record(std::string& out, std::uint8_t opcode, std::string_view content);

std::string encode(const McapSchema& schema);
std::string encode(const McapChannel& channel);
std::string encode(const McapStatistics& statistics);
std::string encode(const McapChunkIndex& index);
std::string encode(const McapAttachmentIndex& index);
std::string encode(const McapMetadata& metadata);

McapSchema decode_schema(std::string_view content);
McapChannel decode_channel(std::string_view content);
McapStatistics decode_statistics(std::string_view content);
McapChunkIndex decode_chunk_index(std::string_view content);
McapAttachmentIndex decode_attachment_index(std::string_view content);
McapMetadata decode_metadata(std::string_view content);

}  // namespace prehend::recording
