#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "prehend/recording/mcap_writer.h"

namespace prehend::recording {

/// When a recording goes on in another file.
struct SplitOptions {
  std::uint64_t size = 0;      ///< [bytes] a file ends with the chunk that reaches it; 0: never
  std::uint64_t duration = 0;  ///< [ns] of log times in a file; 0: no bound
  bool any() const { return size > 0 || duration > 0; }
};

/// Metadata record of every part: its number, and how many messages it begins with that are
/// repeated from the part before.
inline constexpr const char* kPartMetadata = "prehend.part";

/// Writes a recording to one file or, where it is to be split, to parts NAME_0000.mcap,
/// NAME_0001.mcap, ... of NAME.mcap. Every part is a recording of its own, with all schemas,
/// channels, attachments and metadata. A part begins with the latched messages that held when it
/// began: with the log time of its first message, and their own publish time and sequence number.
/// Every message is in exactly one part besides.
///
/// Not thread-safe. Throws as McapWriter; after an error nothing can be written any more, and all
/// parts stay readable.
class SplitWriter {
 public:
  /// Called when a part is closed, for what is to be said at its end.
  using Epilogue = std::function<std::vector<McapMetadata>()>;

  /// Creates the first file, NAME.partial: each becomes NAME once it is whole (recording_file.h). A
  /// `path` that is a symbolic link means what it points to. Throws McapError when that fails,
  /// std::invalid_argument for a split size below 64 kB.
  SplitWriter(const std::string& path, McapWriterOptions options, SplitOptions split,
              Epilogue epilogue = {});

  /// A channel of protobuf messages; the number returned is for write(). `metadata` as in
  /// McapChannel; with kLatchedKey the messages are repeated at the beginning of each part.
  std::size_t add_channel(const std::string& topic, const std::string& schema_name,
                          const std::string& descriptor_set,
                          const std::map<std::string, std::string>& metadata);

  /// Appends a message. `publisher` tells apart those who latch messages of their own each.
  void write(std::size_t channel, std::string_view publisher, std::uint32_t sequence,
             std::uint64_t log_time, std::uint64_t publish_time, const std::string& data);

  void close_chunk_if_old() { writer_->close_chunk_if_old(); }

  /// Written to this part at once, and to all that follow.
  void add_attachment(McapAttachment attachment);
  void add_metadata(McapMetadata metadata);

  void close();

  /// Messages written, the repeated ones not counted.
  std::uint64_t message_count() const { return message_count_; }
  std::uint64_t bytes_written() const { return bytes_of_closed_ + writer_->bytes_written(); }
  /// The files in order, by the names they have now; the last one is being written until close().
  const std::vector<std::string>& files() const { return files_; }
  /// What recorders that were killed had left under the names of these, and where it is now.
  const std::vector<std::string>& left_over() const { return left_over_; }

 private:
  struct Kept {
    std::uint32_t sequence;
    std::uint64_t publish_time;
    std::string data;
  };
  struct Channel {
    std::string topic, schema_name, descriptor_set;
    std::map<std::string, std::string> metadata;
    std::size_t latched_depth = 0;
    std::map<std::string, std::deque<Kept>, std::less<>> latched;  // by publisher
    std::uint16_t id = 0;                                          // in the open part
  };

  void open_part(std::uint64_t log_time);
  void close_part();
  void declare(Channel& channel);
  std::uint64_t repeat_latched(std::uint64_t log_time);
  bool is_full(std::uint64_t log_time) const;

  const std::string path_;
  McapWriterOptions options_;
  const SplitOptions split_;
  const Epilogue epilogue_;
  std::unique_ptr<McapWriter> writer_;
  std::vector<std::string> files_, left_over_;
  std::vector<Channel> channels_;
  std::vector<McapAttachment> attachments_;
  std::vector<McapMetadata> metadata_;
  bool part_has_messages_ = false;
  std::uint64_t part_start_ = 0;  // log time of the first message [ns]
  std::uint64_t message_count_ = 0;
  std::uint64_t bytes_of_closed_ = 0;
};

/// "NAME_0003.mcap" for part 3 of "NAME.mcap".
std::string part_path(const std::string& path, std::size_t part);

}  // namespace prehend::recording
