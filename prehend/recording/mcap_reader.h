#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/recording/byte_file.h"
#include "prehend/recording/mcap_records.h"

namespace prehend::recording {

struct McapMessageFilter {
  std::vector<std::string> topics;  ///< empty: all topics
  std::uint64_t start_time = 0;     ///< least log_time wanted [ns]
  std::uint64_t end_time = std::numeric_limits<std::uint64_t>::max();  ///< greatest wanted [ns]
};

struct McapReaderOptions {
  std::uint64_t largest_chunk = std::uint64_t{1} << 30;  ///< uncompressed bytes; larger: skipped
};

class McapMessageCursor;

/// Reads an MCAP file. The summary at its end is used when it is there and its checksum is right;
/// otherwise (a recorder that was killed, a damaged file) the file is scanned once from the front,
/// and everything whole before the damage is found. Lengths in the file are checked against the
/// file's size before anything is allocated. A chunk with a wrong checksum is skipped.
/// What was skipped, and why, is listed in problems(): reading never fails silently.
class McapReader {
 public:
  /// Opens the file and reads its summary, or scans it. Throws McapError when it cannot be opened
  /// or does not begin as an MCAP file.
  explicit McapReader(const std::string& path, McapReaderOptions options = {});
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  const std::string& path() const { return file_.path(); }
  std::uint64_t file_size() const { return file_.size(); }
  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }

  /// True when the file has its footer, i.e. its writer was closed properly.
  bool complete() const { return complete_; }

  const std::map<std::uint16_t, McapSchema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, McapChannel>& channels() const { return channels_; }
  /// From the summary, or counted by the scan.
  const McapStatistics& statistics() const { return statistics_; }
  const std::vector<McapChunkIndex>& chunks() const { return chunks_; }
  const std::vector<McapAttachmentIndex>& attachments() const { return attachments_; }
  const std::vector<McapMetadata>& metadata() const { return metadata_; }

  /// The channel's schema; nullptr when it has none or the file lacks it.
  const McapSchema* schema_of(const McapChannel& channel) const;

  /// Reads one attachment with its data. Throws McapError when it is damaged.
  McapAttachment read_attachment(const McapAttachmentIndex& index) const;

  /// Messages in order of log_time, in file order among equals. The reader must outlive the cursor.
  McapMessageCursor messages(const McapMessageFilter& filter = {});

  /// One line for everything that was skipped or looked wrong so far, in order of discovery, each
  /// once. Reading messages may add to it.
  const std::vector<std::string>& problems() const { return problems_; }

 private:
  friend class McapMessageCursor;
  // A run of messages that is read at once: a chunk, or one message outside of any chunk.
  struct Block {
    std::uint64_t start_time, end_time, offset, length;
    std::vector<std::uint16_t> channels;  // with messages inside; empty: not known
  };

  void check_magic() const;
  void read_header();
  bool read_summary();
  void take_summary(std::string_view records);
  bool summary_is_usable() const;
  void take_chunk_blocks();
  void forget_contents();
  void scan();
  void scan_record(std::uint8_t opcode, std::uint64_t offset, std::uint64_t length);
  void scan_block(std::uint8_t opcode, std::uint64_t offset, std::uint64_t length);
  void take_schema(McapSchema schema);
  void take_channel(McapChannel channel);
  std::vector<McapMessage> block_messages(const Block& block);
  void take_inner_records(std::uint64_t chunk_offset, std::shared_ptr<const std::string> records,
                          bool cut_off, std::vector<McapMessage>& messages);
  void take_message(std::uint64_t offset, std::string_view content,
                    const std::shared_ptr<const std::string>& storage,
                    std::vector<McapMessage>& messages);
  std::string chunk_records(std::string_view content, bool cut_off) const;
  void report(const std::string& problem);

  const ByteFile file_;
  const McapReaderOptions options_;
  std::string profile_, library_;
  bool complete_ = false;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  McapStatistics statistics_;
  std::vector<McapChunkIndex> chunks_;
  std::vector<McapAttachmentIndex> attachments_;
  std::vector<McapMetadata> metadata_;
  std::vector<Block> blocks_;
  std::vector<std::string> problems_;
};

/// Walks through the messages of a recording in order of log_time, holding in memory only the
/// chunks whose times overlap.
class McapMessageCursor {
 public:
  McapMessageCursor(McapReader& reader, McapMessageFilter filter);

  /// The next message, or nothing at the end. Damaged chunks are skipped and reported in
  /// McapReader::problems().
  std::optional<McapMessage> next();

 private:
  struct Pending {
    McapMessage message;
    std::uint64_t block_offset;  // with `position` the order in the file
    std::size_t position;
  };
  static bool later(const Pending& a, const Pending& b);
  void load(const McapReader::Block& block);
  bool wanted(const McapMessage& message) const;

  McapReader* reader_;
  McapMessageFilter filter_;
  std::vector<McapReader::Block> blocks_;  // by start time
  std::size_t next_block_ = 0;
  std::vector<Pending> pending_;  // heap, earliest on top
};

}  // namespace prehend::recording
