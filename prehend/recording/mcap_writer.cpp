#include "prehend/recording/mcap_writer.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>

#include "prehend/recording/chunk_compression.h"
#include "prehend/recording/record_codec.h"

namespace prehend::recording {
namespace {

constexpr std::size_t kMostIds = std::numeric_limits<std::uint16_t>::max();
constexpr std::uint64_t kMessageFields = 22;  // bytes before a message's data

std::string record(std::uint8_t opcode, std::string_view content) {
  std::string out;
  append_record(out, opcode, content);
  return out;
}

void validate(const McapWriterOptions& options) {
  if (options.chunk_size == 0) throw std::invalid_argument("McapWriterOptions.chunk_size is 0");
  if (options.chunk_age.count() < 0) {
    throw std::invalid_argument("McapWriterOptions.chunk_age is negative");
  }
  if (options.zstd_level < 1 || options.zstd_level > 19) {
    throw std::invalid_argument("McapWriterOptions.zstd_level must be 1..19, is " +
                                std::to_string(options.zstd_level));
  }
}

// The chunk's records as they are stored, and the name of their compression ("" when it did not
// pay).
std::pair<std::string, std::string> pack(std::string_view records,
                                         const McapWriterOptions& options) {
  if (options.compression == Compression::kNone) return {std::string(records), ""};
  const bool lz4 = options.compression == Compression::kLz4;
  std::string packed = lz4 ? compress_lz4(records) : compress_zstd(records, options.zstd_level);
  if (packed.size() >= records.size()) return {std::string(records), ""};
  return {std::move(packed), lz4 ? "lz4" : "zstd"};
}

}  // namespace

Compression compression_named(std::string_view name) {
  if (name == "none") return Compression::kNone;
  if (name == "lz4") return Compression::kLz4;
  if (name == "zstd") return Compression::kZstd;
  throw std::invalid_argument("unknown compression \"" + std::string(name) +
                              "\": must be none, lz4 or zstd");
}

McapWriter::McapWriter(const std::string& path, McapWriterOptions options)
    : path_(path), options_(std::move(options)) {
  validate(options_);
  open_file();
  std::string header;
  FieldWriter writer(header);
  writer.text(options_.profile);
  writer.text(options_.library);
  try {
    put(kMagic, record(kHeader, header));
  } catch (const McapError&) {
    ::close(file_);
    throw;
  }
}

// Locked before it is emptied: two writers of one file would leave nothing of either.
void McapWriter::open_file() {
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file_ < 0) throw McapError("cannot create " + path_ + ": " + std::strerror(errno));
  const bool locked = ::flock(file_, LOCK_EX | LOCK_NB) == 0;
  if (!locked && errno == EWOULDBLOCK) {
    ::close(file_);
    throw McapError("cannot write " + path_ + ": another process is writing it");
  }
  if (::ftruncate(file_, 0) != 0 && errno != EINVAL) {  // EINVAL: it is a device or a pipe
    const int error = errno;
    ::close(file_);
    throw McapError("cannot create " + path_ + ": " + std::strerror(error));
  }
}

McapWriter::~McapWriter() {
  try {
    if (failure_.empty()) close();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  if (file_ >= 0) ::close(file_);
}

void McapWriter::require_open() const {
  if (!failure_.empty()) throw McapError(failure_);
  if (file_ < 0) throw McapError("the recording " + path_ + " is already closed");
}

std::uint16_t McapWriter::add_schema(std::string_view name, std::string_view encoding,
                                     std::string_view data) {
  for (const McapSchema& schema : schemas_) {
    if (schema.name == name && schema.encoding == encoding && schema.data == data) return schema.id;
  }
  if (schemas_.size() == kMostIds) throw McapError("a recording holds at most 65535 schemas");
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  schemas_.push_back({id, std::string(name), std::string(encoding), std::string(data)});
  statistics_.schema_count = id;
  return id;
}

std::uint16_t McapWriter::add_channel(std::string_view topic, std::string_view message_encoding,
                                      std::uint16_t schema_id,
                                      const std::map<std::string, std::string>& metadata) {
  if (schema_id > schemas_.size()) {
    throw std::invalid_argument("add_channel: there is no schema " + std::to_string(schema_id));
  }
  if (channels_.size() == kMostIds) throw McapError("a recording holds at most 65535 channels");
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  channels_.push_back({id, schema_id, std::string(topic), std::string(message_encoding), metadata});
  statistics_.channel_count = id;
  return id;
}

void McapWriter::write(std::uint16_t channel_id, std::uint32_t sequence, std::uint64_t log_time,
                       std::uint64_t publish_time, std::string_view data) {
  write(channel_id, sequence, log_time, publish_time, std::span(&data, 1));
}

void McapWriter::write(std::uint16_t channel_id, std::uint32_t sequence, std::uint64_t log_time,
                       std::uint64_t publish_time, std::span<const std::string_view> parts) {
  require_open();
  if (channel_id == 0 || channel_id > channels_.size()) {
    throw std::invalid_argument("write: there is no channel " + std::to_string(channel_id));
  }
  std::uint64_t length = kMessageFields;
  for (const std::string_view part : parts) length += part.size();

  close_chunk_if_old();
  if (chunk_ && chunk_->records.size() + kRecordPrefix + length > options_.chunk_size)
    close_chunk();
  if (!chunk_) {
    chunk_.emplace(OpenChunk{});
    chunk_->start_time = chunk_->end_time = log_time;
    chunk_->opened = std::chrono::steady_clock::now();
  }
  declare_in_chunk(channel_id);
  chunk_->index[channel_id].emplace_back(log_time, chunk_->records.size());
  FieldWriter writer(chunk_->records);
  writer.u8(kMessage);
  writer.u64(length);
  writer.u16(channel_id);
  writer.u32(sequence);
  writer.u64(log_time);
  writer.u64(publish_time);
  for (const std::string_view part : parts) chunk_->records.append(part);

  chunk_->start_time = std::min(chunk_->start_time, log_time);
  chunk_->end_time = std::max(chunk_->end_time, log_time);
  const bool first = statistics_.message_count == 0;
  statistics_.message_start_time =
      first ? log_time : std::min(statistics_.message_start_time, log_time);
  statistics_.message_end_time =
      first ? log_time : std::max(statistics_.message_end_time, log_time);
  ++statistics_.message_count;
  ++statistics_.channel_message_counts[channel_id];
  if (chunk_->records.size() >= options_.chunk_size) close_chunk();
}

// Schema and channel are repeated in each chunk that uses them: every chunk can be read on its own.
void McapWriter::declare_in_chunk(std::uint16_t channel_id) {
  const auto mark = [](std::vector<bool>& written, std::uint16_t id) {
    if (written.size() <= id) written.resize(id + 1);
    const bool is_new = !written[id];
    written[id] = true;
    return is_new;
  };
  const McapChannel& channel = channels_[channel_id - 1];
  if (!mark(chunk_->channel_written, channel_id)) return;
  if (channel.schema_id != 0 && mark(chunk_->schema_written, channel.schema_id)) {
    append_record(chunk_->records, kSchema, encode(schemas_[channel.schema_id - 1]));
  }
  append_record(chunk_->records, kChannel, encode(channel));
}

void McapWriter::close_chunk_if_old() {
  require_open();
  if (!chunk_) return;
  if (std::chrono::steady_clock::now() - chunk_->opened >= options_.chunk_age) close_chunk();
}

void McapWriter::close_chunk() {
  OpenChunk chunk = std::move(*chunk_);
  chunk_.reset();
  const auto [packed, compression] = pack(chunk.records, options_);

  McapChunkIndex index;
  index.message_start_time = chunk.start_time;
  index.message_end_time = chunk.end_time;
  index.chunk_start_offset = position_;
  index.compression = compression;
  index.compressed_size = packed.size();
  index.uncompressed_size = chunk.records.size();

  std::string fields;
  FieldWriter writer(fields);
  writer.u64(chunk.start_time);
  writer.u64(chunk.end_time);
  writer.u64(chunk.records.size());
  writer.u32(options_.chunk_crc ? crc32_of(chunk.records) : 0);
  writer.text(compression);
  writer.u64(packed.size());
  std::string prefix;
  FieldWriter prefix_writer(prefix);
  prefix_writer.u8(kChunk);
  prefix_writer.u64(fields.size() + packed.size());
  prefix += fields;
  index.chunk_length = prefix.size() + packed.size();

  std::string message_indexes;
  for (auto& [channel, entries] : chunk.index) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    index.message_index_offsets[channel] = position_ + index.chunk_length + message_indexes.size();
    std::string content;
    FieldWriter entry_writer(content);
    entry_writer.u16(channel);
    entry_writer.u32(static_cast<std::uint32_t>(entries.size() * 16));
    for (const auto& [time, offset] : entries) {
      entry_writer.u64(time);
      entry_writer.u64(offset);
    }
    append_record(message_indexes, kMessageIndex, content);
  }
  index.message_index_length = message_indexes.size();
  put(prefix, packed, message_indexes);
  chunk_indexes_.push_back(std::move(index));
  ++statistics_.chunk_count;
}

void McapWriter::add_attachment(const McapAttachment& attachment) {
  require_open();
  std::string fields;
  FieldWriter writer(fields);
  writer.u64(attachment.log_time);
  writer.u64(attachment.create_time);
  writer.text(attachment.name);
  writer.text(attachment.media_type);
  writer.u64(attachment.data.size());
  std::string crc;
  FieldWriter(crc).u32(options_.chunk_crc ? crc32_of(attachment.data, crc32_of(fields)) : 0);
  std::string prefix;
  FieldWriter prefix_writer(prefix);
  prefix_writer.u8(kAttachment);
  prefix_writer.u64(fields.size() + attachment.data.size() + crc.size());
  prefix += fields;

  attachment_indexes_.push_back({position_, prefix.size() + attachment.data.size() + crc.size(),
                                 attachment.log_time, attachment.create_time,
                                 attachment.data.size(), attachment.name, attachment.media_type});
  put(prefix, attachment.data, crc);
  ++statistics_.attachment_count;
}

void McapWriter::add_metadata(const McapMetadata& metadata) {
  require_open();
  const std::string bytes = record(kMetadata, encode(metadata));
  metadata_indexes_.push_back({metadata.name, {position_, bytes.size()}});
  put(bytes);
  ++statistics_.metadata_count;
}

void McapWriter::close() {
  if (file_ < 0) return;
  require_open();
  if (chunk_) close_chunk();
  declare_unused_channels();
  std::string crc;
  FieldWriter(crc).u32(options_.data_section_crc ? data_section_crc_ : 0);
  put(record(kDataEnd, crc));
  write_summary();
  const int file = file_;
  file_ = -1;
  if (::close(file) != 0) {
    failure_ = "cannot finish " + path_ + ": " + std::strerror(errno);
    throw McapError(failure_);
  }
}

// Channels without messages are in no chunk, yet the summary names them.
void McapWriter::declare_unused_channels() {
  std::string bytes;
  std::vector<bool> schema_declared(schemas_.size() + 1);
  for (const McapChannel& channel : channels_) {
    if (statistics_.channel_message_counts.count(channel.id) > 0) {
      schema_declared[channel.schema_id] = true;
    }
  }
  for (const McapSchema& schema : schemas_) {
    if (!schema_declared[schema.id]) append_record(bytes, kSchema, encode(schema));
  }
  for (const McapChannel& channel : channels_) {
    if (statistics_.channel_message_counts.count(channel.id) > 0) continue;
    append_record(bytes, kChannel, encode(channel));
  }
  if (!bytes.empty()) put(bytes);
}

std::string McapWriter::summary_groups(std::string* summary_offsets) const {
  std::string summary;
  std::uint64_t group_start = 0;
  const auto end_group = [&](std::uint8_t opcode) {
    if (summary.size() == group_start) return;
    std::string content;
    FieldWriter writer(content);
    writer.u8(opcode);
    writer.u64(position_ + group_start);
    writer.u64(summary.size() - group_start);
    append_record(*summary_offsets, kSummaryOffset, content);
    group_start = summary.size();
  };
  for (const McapSchema& schema : schemas_) append_record(summary, kSchema, encode(schema));
  end_group(kSchema);
  for (const McapChannel& channel : channels_) append_record(summary, kChannel, encode(channel));
  end_group(kChannel);
  append_record(summary, kStatistics, encode(statistics_));
  end_group(kStatistics);
  for (const auto& index : chunk_indexes_) append_record(summary, kChunkIndex, encode(index));
  end_group(kChunkIndex);
  for (const auto& index : attachment_indexes_) {
    append_record(summary, kAttachmentIndex, encode(index));
  }
  end_group(kAttachmentIndex);
  for (const auto& [name, place] : metadata_indexes_) {
    std::string content;
    FieldWriter writer(content);
    writer.u64(place.first);
    writer.u64(place.second);
    writer.text(name);
    append_record(summary, kMetadataIndex, content);
  }
  end_group(kMetadataIndex);
  return summary;
}

void McapWriter::write_summary() {
  std::string summary_offsets;
  std::string end = summary_groups(&summary_offsets);
  const std::uint64_t summary_start = position_;
  const std::uint64_t summary_offset_start = position_ + end.size();
  end += summary_offsets;
  FieldWriter writer(end);
  writer.u8(kFooter);
  writer.u64(kFooterBytes - kRecordPrefix);
  writer.u64(summary_start);
  writer.u64(summary_offset_start);
  writer.u32(options_.summary_crc ? crc32_of(end) : 0);
  put(end, kMagic);
}

void McapWriter::put(std::string_view first, std::string_view second, std::string_view third) {
  const std::uint64_t last_whole_record = position_;
  std::array<std::string_view, 3> parts{first, second, third};
  if (options_.data_section_crc) {
    for (const auto part : parts) data_section_crc_ = crc32_of(part, data_section_crc_);
  }
  std::size_t left = first.size() + second.size() + third.size();
  while (left > 0) {
    std::array<iovec, 3> vectors;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      vectors[i] = {const_cast<char*>(parts[i].data()), parts[i].size()};
    }
    const ssize_t written = ::writev(file_, vectors.data(), static_cast<int>(vectors.size()));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      failure_ = "cannot write " + path_ + ": " +
                 (written < 0 ? std::strerror(errno) : "nothing was written") +
                 "; the recording ends there";
      // Drop the torn record; if even this fails readers stop at it by themselves.
      if (::ftruncate(file_, static_cast<off_t>(last_whole_record)) != 0) {
        failure_ += " (with a torn record)";
      }
      throw McapError(failure_);
    }
    position_ += static_cast<std::uint64_t>(written);
    left -= static_cast<std::size_t>(written);
    std::size_t skip = static_cast<std::size_t>(written);
    for (std::string_view& part : parts) {
      const std::size_t taken = std::min(skip, part.size());
      part.remove_prefix(taken);
      skip -= taken;
    }
  }
}

}  // namespace prehend::recording
