#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

/// Records of the MCAP container format (public specification: github.com/foxglove/mcap,
/// website/docs/spec), as far as users of the writer and the reader see them. Times are nanoseconds
/// since an epoch the recording's author chose: Unix in live runs, the simulation's start in
/// simulated ones.
namespace prehend::recording {

/// A file that cannot be opened, written or understood. what() names the file, what happened and,
/// where there is one, the mend.
class McapError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How a message's bytes are to be read. For protobuf: `name` is the full message name without a
/// leading dot, `data` a serialised google.protobuf.FileDescriptorSet (see protobuf_schema.h).
struct McapSchema {
  std::uint16_t id = 0;  ///< 1..65535
  std::string name;
  std::string encoding;
  std::string data;
  bool operator==(const McapSchema&) const = default;
};

/// A stream of messages of one schema on one topic.
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  ///< 0: messages have no schema
  std::string topic;
  std::string message_encoding;
  std::map<std::string, std::string> metadata;
  bool operator==(const McapChannel&) const = default;
};

/// One message as it was read. `data` points into `storage`, which lives as long as any message of
/// the same chunk, so copying a McapMessage does not copy its bytes.
struct McapMessage {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;      ///< per channel; 0 when unused
  std::uint64_t log_time = 0;      ///< when it was recorded [ns]
  std::uint64_t publish_time = 0;  ///< when it was published [ns]
  std::string_view data;
  std::shared_ptr<const std::string> storage;
};

/// A whole file carried inside a recording, such as the launch file of the run.
struct McapAttachment {
  std::uint64_t log_time = 0;     ///< [ns]
  std::uint64_t create_time = 0;  ///< [ns], 0 when unknown
  std::string name;
  std::string media_type;  ///< e.g. "text/yaml"
  std::string data;
};

/// Where an attachment lies in the file, without its data.
struct McapAttachmentIndex {
  std::uint64_t offset = 0;  ///< of the record's opcode [bytes]
  std::uint64_t length = 0;  ///< of the whole record [bytes]
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::uint64_t data_size = 0;  ///< [bytes]
  std::string name;
  std::string media_type;
};

/// Named key-value pairs about the recording as a whole.
struct McapMetadata {
  std::string name;
  std::map<std::string, std::string> entries;
};

/// Where a chunk and its message indexes lie in the file.
struct McapChunkIndex {
  std::uint64_t message_start_time = 0;                          ///< least log_time inside [ns]
  std::uint64_t message_end_time = 0;                            ///< greatest log_time inside [ns]
  std::uint64_t chunk_start_offset = 0;                          ///< of the Chunk's opcode [bytes]
  std::uint64_t chunk_length = 0;                                ///< of the whole record [bytes]
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;  ///< channel -> file offset
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0;
  std::uint64_t uncompressed_size = 0;
};

struct McapStatistics {
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  std::uint32_t attachment_count = 0;
  std::uint32_t metadata_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t message_start_time = 0;  ///< 0 when there are no messages [ns]
  std::uint64_t message_end_time = 0;    ///< 0 when there are no messages [ns]
  std::map<std::uint16_t, std::uint64_t> channel_message_counts;
};

}  // namespace prehend::recording
