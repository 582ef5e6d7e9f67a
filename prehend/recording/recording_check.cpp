#include "prehend/recording/recording_check.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "prehend/recording/byte_file.h"
#include "prehend/recording/chunk_compression.h"
#include "prehend/recording/message_decoder.h"
#include "prehend/recording/record_codec.h"

namespace prehend::recording {
namespace {

constexpr std::size_t kMostListed = 100;
constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 30;  // bytes, unpacked

class Check {
 public:
  explicit Check(const std::string& path) : file_(path) {}
  RecordingCheck run();

 private:
  using Places = std::map<std::uint64_t, std::pair<std::uint16_t, std::uint64_t>>;
  // The chunk read last, until the record after its indexes.
  struct LastChunk {
    std::uint64_t offset = 0;
    Places messages;  // offset inside -> channel, log time
    std::map<std::uint16_t, std::uint64_t> counts, indexed;
  };

  void report(const std::string& problem);
  void read_record(std::uint8_t opcode, std::uint64_t offset, std::string_view content);
  void read_data_record(std::uint8_t opcode, std::uint64_t offset, std::string_view content);
  void read_summary_record(std::uint8_t opcode, std::uint64_t offset, std::string_view content);
  void read_chunk(std::uint64_t offset, std::string_view content);
  void read_inner_records(std::string_view records, LastChunk& chunk);
  void read_message(std::string_view content, std::uint64_t place);
  void read_message_index(std::uint64_t offset, std::string_view content);
  void end_chunk();
  void read_attachment(std::uint64_t offset, std::string_view content);
  void read_footer(std::uint64_t offset, std::string_view content);
  void take(const McapSchema& schema, std::uint64_t offset);
  void take(const McapChannel& channel, std::uint64_t offset);
  void compare_statistics(const McapStatistics& told);
  void compare_chunk_index(const McapChunkIndex& index);

  const ByteFile file_;
  std::uint32_t data_crc_ = 0;  // of what was read up to now
  RecordingCheck result_;
  MessageDecoder decoder_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::map<std::uint16_t, std::uint64_t> last_time_;
  std::map<std::uint64_t, McapChunkIndex> chunks_;                 // by offset
  std::map<std::uint64_t, std::uint64_t> attachments_, metadata_;  // offset -> length
  McapStatistics counted_;
  std::uint64_t chunk_indexes_ = 0;
  std::optional<LastChunk> last_chunk_;
  bool in_summary_ = false, footer_read_ = false;
  std::uint64_t summary_start_ = 0;
};

void Check::report(const std::string& problem) {
  if (result_.problems.size() < kMostListed) {
    result_.problems.push_back(problem);
  } else {
    ++result_.further_problems;
  }
}

RecordingCheck Check::run() {
  std::uint64_t offset = kMagic.size();
  if (file_.size() < offset || file_.read(0, offset) != kMagic) {
    throw McapError(file_.path() +
                    " is not an MCAP recording (it does not begin with the MCAP magic)");
  }
  data_crc_ = crc32_of(kMagic);
  while (!footer_read_ && file_.size() - offset >= kRecordPrefix) {
    const std::string prefix = file_.read(offset, kRecordPrefix);
    FieldReader fields(prefix);
    const std::uint8_t opcode = fields.u8();
    const std::uint64_t length = fields.u64();
    if (length > file_.size() - offset - kRecordPrefix) {
      report("the record" + at_byte(offset) + " runs past the file's end");
      break;
    }
    if (opcode == 0) {
      report("the record" + at_byte(offset) + " has the invalid opcode 0");
      break;
    }
    const std::string content = file_.read(offset + kRecordPrefix, length);
    try {
      read_record(opcode, offset, content);
    } catch (const McapError& error) {
      report("the record" + at_byte(offset) + " is damaged: " + error.what());
    }
    if (!in_summary_) data_crc_ = crc32_of(content, crc32_of(prefix, data_crc_));
    offset += kRecordPrefix + length;
  }
  end_chunk();
  if (!footer_read_) {
    report(
        "the file ends without a footer: its writer was stopped, or it is cut off; prehend bag "
        "recover mends it");
  } else if (file_.read(offset, file_.size() - offset) != kMagic) {
    report("the file does not end with the MCAP magic after its footer");
  }
  return std::move(result_);
}

void Check::read_record(std::uint8_t opcode, std::uint64_t offset, std::string_view content) {
  if (opcode != kMessageIndex) end_chunk();
  if (opcode == kFooter) return read_footer(offset, content);
  if (in_summary_) return read_summary_record(opcode, offset, content);
  read_data_record(opcode, offset, content);
}

void Check::read_data_record(std::uint8_t opcode, std::uint64_t offset, std::string_view content) {
  switch (opcode) {
    case kHeader:
      if (offset != kMagic.size()) report("a second Header record" + at_byte(offset));
      return;
    case kSchema:
      return take(decode_schema(content), offset);
    case kChannel:
      return take(decode_channel(content), offset);
    case kMessage:
      return read_message(content, offset);
    case kChunk:
      return read_chunk(offset, content);
    case kMessageIndex:
      return read_message_index(offset, content);
    case kAttachment:
      return read_attachment(offset, content);
    case kMetadata:
      decode_metadata(content);
      metadata_[offset] = kRecordPrefix + content.size();
      return;
    case kDataEnd: {
      FieldReader fields(content);
      const std::uint32_t crc = fields.u32();
      if (!fields.rest().empty()) report("the DataEnd record" + at_byte(offset) + " is too long");
      if (crc == 0) {
        result_.notes.push_back(
            "the data section has no checksum: its writer left it out, so changes outside of "
            "chunks and attachments (header, metadata, indexes) may not be seen");
      } else if (data_crc_ != crc) {
        report("the checksum of the data section is wrong");
      }
      in_summary_ = true;
      summary_start_ = offset + kRecordPrefix + content.size();
      return;
    }
    default:
      return;  // unknown records are allowed
  }
}

void Check::take(const McapSchema& schema, std::uint64_t offset) {
  const auto [known, is_new] = schemas_.try_emplace(schema.id, schema);
  if (!is_new) {
    if (known->second != schema) {
      report("the schema " + schema.name + at_byte(offset) + " differs from another one of its id");
    }
    return;
  }
  const std::string problem = decoder_.add(schema);
  if (!problem.empty()) report(problem);
}

void Check::take(const McapChannel& channel, std::uint64_t offset) {
  const auto [known, is_new] = channels_.try_emplace(channel.id, channel);
  if (!is_new && known->second != channel) {
    report("the channel " + channel.topic + at_byte(offset) +
           " differs from another one of its id");
  }
  if (is_new && channel.schema_id != 0 && schemas_.count(channel.schema_id) == 0) {
    report("the channel " + channel.topic + at_byte(offset) + " has the schema " +
           std::to_string(channel.schema_id) + ", which was not declared before");
  }
}

void Check::read_chunk(std::uint64_t offset, std::string_view content) {
  FieldReader fields(content);
  McapChunkIndex index;
  index.message_start_time = fields.u64();
  index.message_end_time = fields.u64();
  index.chunk_start_offset = offset;
  index.chunk_length = kRecordPrefix + content.size();
  index.uncompressed_size = fields.u64();
  const std::uint32_t crc = fields.u32();
  index.compression = fields.text();
  index.compressed_size = fields.u64();
  chunks_[offset] = index;
  ++result_.chunks;
  if (index.uncompressed_size > kLargestChunk) throw McapError("it unpacks to more than 1 GiB");
  const std::string records = decompress(
      index.compression, std::string(fields.raw(index.compressed_size)), index.uncompressed_size);
  if (crc != 0 && crc32_of(records) != crc) throw McapError("its checksum is wrong");
  LastChunk chunk;
  chunk.offset = offset;
  read_inner_records(records, chunk);
  std::uint64_t start = 0, end = 0;
  for (const auto& [place, message] : chunk.messages) {
    const bool first = place == chunk.messages.begin()->first;
    start = first ? message.second : std::min(start, message.second);
    end = std::max(end, message.second);
  }
  if (start != index.message_start_time || end != index.message_end_time) {
    report("the chunk" + at_byte(offset) + " declares other times than those of its messages");
  }
  last_chunk_ = std::move(chunk);
}

void Check::read_inner_records(std::string_view records, LastChunk& chunk) {
  FieldReader reader(records);
  while (!reader.rest().empty()) {
    const std::uint64_t place = records.size() - reader.rest().size();
    const std::uint8_t opcode = reader.u8();
    const std::string_view content = reader.raw(reader.u64());
    if (opcode == kSchema) take(decode_schema(content), chunk.offset);
    if (opcode == kChannel) take(decode_channel(content), chunk.offset);
    if (opcode != kMessage) continue;
    FieldReader message(content);
    const std::uint16_t channel = message.u16();
    message.u32();
    chunk.messages[place] = {channel, message.u64()};
    ++chunk.counts[channel];
    read_message(content, chunk.offset);
  }
}

void Check::read_message(std::string_view content, std::uint64_t place) {
  FieldReader fields(content);
  const std::uint16_t id = fields.u16();
  const std::uint32_t sequence = fields.u32();
  const std::uint64_t log_time = fields.u64();
  fields.u64();
  const auto name = [&] { return "message " + std::to_string(sequence); };
  ++result_.messages;
  auto& start = counted_.message_start_time;
  start = counted_.message_count == 0 ? log_time : std::min(start, log_time);
  counted_.message_end_time = std::max(counted_.message_end_time, log_time);
  ++counted_.message_count;
  ++counted_.channel_message_counts[id];
  const auto channel = channels_.find(id);
  if (channel == channels_.end()) {
    report(name() + at_byte(place) + " is of channel " + std::to_string(id) +
           ", which was not declared before");
    return;
  }
  const std::string& topic = channel->second.topic;
  auto& last = last_time_[id];
  if (log_time < last)
    report(topic + ": " + name() + at_byte(place) + " is earlier than the one before");
  last = std::max(last, log_time);
  const std::uint16_t schema = channel->second.schema_id;
  if (decoder_.knows(schema) && !decoder_.decode(schema, fields.rest())) {
    report(topic + ": " + name() + at_byte(place) + " cannot be decoded");
  }
}

void Check::read_message_index(std::uint64_t offset, std::string_view content) {
  if (!last_chunk_) {
    report("the message index" + at_byte(offset) + " follows no readable chunk");
    return;
  }
  FieldReader fields(content);
  const std::uint16_t channel = fields.u16();
  FieldReader entries(fields.raw(fields.u32()));
  while (!entries.rest().empty()) {
    const std::uint64_t time = entries.u64();
    const auto message = last_chunk_->messages.find(entries.u64());
    if (message == last_chunk_->messages.end() || message->second != std::pair(channel, time)) {
      report("the message index" + at_byte(offset) + " names a message that is not there");
    }
    ++last_chunk_->indexed[channel];
  }
  chunks_[last_chunk_->offset].message_index_offsets[channel] = offset;
  chunks_[last_chunk_->offset].message_index_length += kRecordPrefix + content.size();
}

void Check::end_chunk() {
  if (!last_chunk_) return;
  if (!last_chunk_->indexed.empty() && last_chunk_->indexed != last_chunk_->counts) {
    report("the message indexes of the chunk" + at_byte(last_chunk_->offset) +
           " do not cover its messages");
  }
  last_chunk_.reset();
}

void Check::read_attachment(std::uint64_t offset, std::string_view content) {
  attachments_[offset] = kRecordPrefix + content.size();
  ++result_.attachments;
  FieldReader fields(content);
  fields.u64();
  fields.u64();
  const std::string name = fields.text();
  fields.text();
  fields.raw(fields.u64());
  const std::string_view covered = content.substr(0, content.size() - fields.rest().size());
  const std::uint32_t crc = fields.u32();
  if (crc != 0 && crc32_of(covered) != crc) {
    report("the attachment " + name + at_byte(offset) + " is damaged: its checksum is wrong");
  }
}

void Check::read_summary_record(std::uint8_t opcode, std::uint64_t offset,
                                std::string_view content) {
  const auto require = [&](bool right, const char* what) {
    if (!right) report(std::string("the summary") + at_byte(offset) + what);
  };
  switch (opcode) {
    case kSchema:
      return take(decode_schema(content), offset);
    case kChannel:
      return take(decode_channel(content), offset);
    case kStatistics:
      return compare_statistics(decode_statistics(content));
    case kChunkIndex:
      return compare_chunk_index(decode_chunk_index(content));
    case kAttachmentIndex: {
      const auto index = decode_attachment_index(content);
      const auto found = attachments_.find(index.offset);
      return require(found != attachments_.end() && found->second == index.length,
                     " names an attachment that is not there");
    }
    case kMetadataIndex: {
      FieldReader fields(content);
      const auto found = metadata_.find(fields.u64());
      return require(found != metadata_.end() && found->second == fields.u64(),
                     " names metadata that are not there");
    }
    case kSummaryOffset: {
      FieldReader fields(content);
      const std::uint8_t group = fields.u8();
      const std::uint64_t start = fields.u64(), length = fields.u64();
      return require(start >= summary_start_ && start < offset && length <= offset - start &&
                         static_cast<std::uint8_t>(file_.read(start, 1)[0]) == group,
                     " has an offset that points to no such group");
    }
    default:
      return;
  }
}

void Check::compare_statistics(const McapStatistics& told) {
  const auto compare = [&](std::uint64_t says, std::uint64_t is, const char* what) {
    if (says != is)
      report(std::string("the statistics say ") + std::to_string(says) + " " + what +
             ", there are " + std::to_string(is));
  };
  compare(told.message_count, counted_.message_count, "messages");
  compare(told.chunk_count, chunks_.size(), "chunks");
  compare(told.attachment_count, attachments_.size(), "attachments");
  compare(told.metadata_count, metadata_.size(), "metadata records");
  compare(told.channel_count, channels_.size(), "channels");
  compare(told.schema_count, schemas_.size(), "schemas");
  if (told.message_start_time != counted_.message_start_time ||
      told.message_end_time != counted_.message_end_time) {
    report("the statistics' times are not those of the messages");
  }
  if (!told.channel_message_counts.empty() &&
      told.channel_message_counts != counted_.channel_message_counts) {
    report("the statistics' counts of the channels' messages are wrong");
  }
}

void Check::compare_chunk_index(const McapChunkIndex& index) {
  ++chunk_indexes_;
  const auto found = chunks_.find(index.chunk_start_offset);
  if (found == chunks_.end()) {
    report("the summary names a chunk" + at_byte(index.chunk_start_offset) + " that is not there");
    return;
  }
  if (encode(found->second) != encode(index)) {
    report("the summary's index of the chunk" + at_byte(index.chunk_start_offset) + " is wrong");
  }
}

void Check::read_footer(std::uint64_t offset, std::string_view content) {
  footer_read_ = true;
  FieldReader fields(content);
  const std::uint64_t start = fields.u64();
  fields.u64();
  const std::uint32_t crc = fields.u32();
  if (!fields.rest().empty()) report("the Footer record" + at_byte(offset) + " is too long");
  if (crc == 0) {
    result_.notes.push_back(
        "the summary has no checksum: its writer left it out, so changes there may not be seen");
  }
  if (!in_summary_) report("there is no DataEnd record before the footer");
  if (start != 0 && start != summary_start_) report("the footer points to no summary");
  const std::uint64_t from = start == 0 ? offset : std::min(start, offset);
  const std::uint64_t covered = offset + kFooterBytes - 4 - from;
  if (crc != 0 && crc32_of(file_.read(from, covered)) != crc) {
    report("the summary's checksum is wrong");
  }
  if (chunk_indexes_ > 0 && chunk_indexes_ != chunks_.size()) {
    report("the summary names " + std::to_string(chunk_indexes_) + " chunks, there are " +
           std::to_string(chunks_.size()));
  }
}

}  // namespace

RecordingCheck check_recording(const std::string& path) { return Check(path).run(); }

}  // namespace prehend::recording
