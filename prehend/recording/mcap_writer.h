#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "prehend/recording/mcap_records.h"

namespace prehend::recording {

enum class Compression { kNone, kLz4, kZstd };

/// "none", "lz4" or "zstd"; throws std::invalid_argument naming the three for anything else.
Compression compression_named(std::string_view name);

struct McapWriterOptions {
  Compression compression = Compression::kLz4;
  int zstd_level = 1;                         ///< 1 (fast) .. 19 (small); only for kZstd
  std::uint64_t chunk_size = 1024 * 1024;     ///< uncompressed bytes at which a chunk is closed
  std::chrono::milliseconds chunk_age{1000};  ///< wall time after which a chunk is closed
  bool chunk_crc = true;                      ///< checksum of each chunk and attachment
  bool summary_crc = true;                    ///< checksum of the summary section
  /// Checksum of all before the summary: the only one that covers header, metadata and indexes. One
  /// more pass over every stored byte, about 1 ns each.
  bool data_section_crc = true;
  std::string profile;
  std::string library = "prehend";
};

/// Writes one MCAP file, front to back, never seeking. A file whose writer was killed can be read
/// up to its last closed chunk; chunks close at `chunk_size` or when `chunk_age` old, so that a
/// crash costs at most that much. Each chunk with its indexes goes out in one system call.
///
/// Not thread-safe. Every member throws McapError when the file cannot be written (disk full, ...);
/// from then on the writer refuses everything and the file stays readable up to its last whole
/// record.
class McapWriter {
 public:
  /// Creates or overwrites the file `path` and writes its header. Throws McapError when that fails
  /// or another process is writing the file, std::invalid_argument for a chunk size of 0, a
  /// negative age or a zstd level outside 1..19.
  explicit McapWriter(const std::string& path, McapWriterOptions options = {});

  /// Calls close() when that was not done; an error is then printed to stderr, so call close().
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Registers a schema; the same three values give the same id. Nothing is written yet.
  /// Throws McapError beyond 65535 schemas.
  std::uint16_t add_schema(std::string_view name, std::string_view encoding, std::string_view data);

  /// Registers a channel, always a new one. `schema_id` is 0 or comes from add_schema, else
  /// std::invalid_argument. Throws McapError beyond 65535 channels.
  std::uint16_t add_channel(std::string_view topic, std::string_view message_encoding,
                            std::uint16_t schema_id,
                            const std::map<std::string, std::string>& metadata = {});

  /// Appends a message whose bytes are the concatenation of `parts`, copying them once. Closes the
  /// open chunk before (when the message does not fit or the chunk is too old) or after it (when
  /// full): then the call costs compression and a disk write. `channel_id` must come from
  /// add_channel, else std::invalid_argument. Times in nanoseconds.
  void write(std::uint16_t channel_id, std::uint32_t sequence, std::uint64_t log_time,
             std::uint64_t publish_time, std::span<const std::string_view> parts);
  void write(std::uint16_t channel_id, std::uint32_t sequence, std::uint64_t log_time,
             std::uint64_t publish_time, std::string_view data);

  /// Closes the open chunk if it is older than `chunk_age`. Call it when no messages arrive.
  void close_chunk_if_old();

  /// Writes an attachment or metadata at once (outside of chunks).
  void add_attachment(const McapAttachment& attachment);
  void add_metadata(const McapMetadata& metadata);

  /// Writes the last chunk, the summary and the footer, and closes the file. Further calls to
  /// close() do nothing.
  void close();

  /// What has been written or buffered so far.
  const McapStatistics& statistics() const { return statistics_; }
  /// Bytes in the file so far; messages of the open chunk are not in it.
  std::uint64_t bytes_written() const { return position_; }

 private:
  struct OpenChunk {
    std::string records;
    std::uint64_t start_time = 0, end_time = 0;
    std::vector<bool> schema_written, channel_written;  // by id
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index;
    std::chrono::steady_clock::time_point opened;
  };

  void open_file();
  void require_open() const;
  void close_chunk();
  void declare_in_chunk(std::uint16_t channel_id);
  void declare_unused_channels();
  void write_summary();
  std::string summary_groups(std::string* summary_offsets) const;
  void put(std::string_view first, std::string_view second = {}, std::string_view third = {});

  const std::string path_;
  const McapWriterOptions options_;
  int file_ = -1;
  std::uint64_t position_ = 0;
  std::uint32_t data_section_crc_ = 0;
  std::string failure_;                // why writing stopped for good
  std::vector<McapSchema> schemas_;    // id = position + 1
  std::vector<McapChannel> channels_;  // id = position + 1
  std::optional<OpenChunk> chunk_;
  std::vector<McapChunkIndex> chunk_indexes_;
  std::vector<McapAttachmentIndex> attachment_indexes_;
  std::vector<std::pair<std::string, std::pair<std::uint64_t, std::uint64_t>>> metadata_indexes_;
  McapStatistics statistics_;
};

}  // namespace prehend::recording
