// How McapReader finds out what is in a file: from its summary, or by a scan from the front.

#include <algorithm>
#include <utility>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/record_codec.h"

namespace prehend::recording {

bool McapReader::read_summary() {
  const std::uint64_t end_bytes = kFooterBytes + kMagic.size();
  if (file_.size() < kMagic.size() + end_bytes) return false;
  const std::uint64_t footer_offset = file_.size() - end_bytes;
  const std::string end = file_.read(footer_offset, end_bytes);
  FieldReader footer(end);
  if (!end.ends_with(kMagic) || footer.u8() != kFooter ||
      footer.u64() != kFooterBytes - kRecordPrefix) {
    return false;
  }
  complete_ = true;
  const std::uint64_t summary_start = footer.u64();
  footer.u64();  // the summary offsets only save seeking
  const std::uint32_t crc = footer.u32();
  if (summary_start == 0) return false;
  if (summary_start < kMagic.size() || summary_start > footer_offset) {
    report("the footer points outside of the file; the file was scanned instead");
    return false;
  }
  const std::string summary =
      file_.read(summary_start, footer_offset + kFooterBytes - 4 - summary_start);
  if (crc != 0 && crc32_of(summary) != crc) {
    report("the summary's checksum is wrong; the file was scanned instead");
    return false;
  }
  try {
    take_summary(std::string_view(summary).substr(0, footer_offset - summary_start));
    if (summary_is_usable()) {
      take_chunk_blocks();
      return true;
    }
  } catch (const McapError& error) {
    report("the summary is damaged (" + std::string(error.what()) +
           "); the file was scanned instead");
  }
  forget_contents();
  return false;
}

void McapReader::take_summary(std::string_view records) {
  FieldReader reader(records);
  while (!reader.rest().empty()) {
    const std::uint8_t opcode = reader.u8();
    const std::string_view content = reader.raw(reader.u64());
    if (opcode == kSchema) take_schema(decode_schema(content));
    if (opcode == kChannel) take_channel(decode_channel(content));
    if (opcode == kStatistics) statistics_ = decode_statistics(content);
    if (opcode == kChunkIndex) chunks_.push_back(decode_chunk_index(content));
    if (opcode == kAttachmentIndex) attachments_.push_back(decode_attachment_index(content));
    if (opcode == kMetadataIndex) {
      FieldReader index(content);
      const std::uint64_t offset = index.u64();
      const std::uint64_t length = index.u64();
      if (length < kRecordPrefix) throw McapError("a metadata index points to no record");
      metadata_.push_back(
          decode_metadata(std::string_view(file_.read(offset, length)).substr(kRecordPrefix)));
    }
  }
}

// Writers may leave out any part of the summary; then the scan finds what is missing.
bool McapReader::summary_is_usable() const {
  const auto& counts = statistics_.channel_message_counts;
  return chunks_.size() == statistics_.chunk_count &&
         attachments_.size() == statistics_.attachment_count &&
         metadata_.size() == statistics_.metadata_count &&
         channels_.size() == statistics_.channel_count && !channels_.empty() &&
         (statistics_.message_count == 0 || !chunks_.empty()) &&
         std::all_of(counts.begin(), counts.end(),
                     [this](const auto& count) { return channels_.count(count.first) > 0; });
}

void McapReader::take_chunk_blocks() {
  for (const McapChunkIndex& chunk : chunks_) {
    const bool inside = chunk.chunk_start_offset <= file_.size() &&
                        chunk.chunk_length <= file_.size() - chunk.chunk_start_offset &&
                        chunk.chunk_length >= kRecordPrefix;
    if (!inside) throw McapError("a chunk index points outside of the file");
    Block block{chunk.message_start_time,
                chunk.message_end_time,
                chunk.chunk_start_offset,
                chunk.chunk_length,
                {}};
    for (const auto& [channel, offset] : chunk.message_index_offsets) {
      block.channels.push_back(channel);
    }
    blocks_.push_back(std::move(block));
  }
}

void McapReader::scan() {
  std::uint64_t offset = kMagic.size();
  bool footer_found = false;
  while (!footer_found && file_.size() - offset >= kRecordPrefix) {
    const std::string prefix = file_.read(offset, kRecordPrefix);
    FieldReader fields(prefix);
    const std::uint8_t opcode = fields.u8();
    const std::uint64_t length = fields.u64();
    const std::uint64_t available = file_.size() - offset - kRecordPrefix;
    if (opcode == 0) {
      report("the record at byte " + std::to_string(offset) +
             " has the invalid opcode 0; nothing after it was read");
      return;
    }
    footer_found = opcode == kFooter;
    if (length > available) {
      if (opcode == kChunk) scan_block(opcode, offset, file_.size() - offset);
      break;
    }
    try {
      scan_record(opcode, offset, length);
    } catch (const McapError& error) {
      report("skipped the record at byte " + std::to_string(offset) + ": " + error.what());
    }
    offset += kRecordPrefix + length;
  }
  if (!complete_) {
    report("the file ends without a footer (its writer was stopped, or it is cut off); " +
           std::to_string(file_.size() - offset) + " bytes at its end are of no whole record");
  }
}

void McapReader::scan_record(std::uint8_t opcode, std::uint64_t offset, std::uint64_t length) {
  const auto content = [&] { return file_.read(offset + kRecordPrefix, length); };
  switch (opcode) {
    case kSchema:
      take_schema(decode_schema(content()));
      statistics_.schema_count = static_cast<std::uint16_t>(schemas_.size());
      break;
    case kChannel:
      take_channel(decode_channel(content()));
      statistics_.channel_count = static_cast<std::uint32_t>(channels_.size());
      break;
    case kChunk:
    case kMessage:
      scan_block(opcode, offset, kRecordPrefix + length);
      break;
    case kAttachment: {
      // The fields before the data are read; the data can be large and is left alone.
      constexpr std::uint64_t kLongestFields = 1 << 16;
      const std::string head = file_.read(offset + kRecordPrefix, std::min(length, kLongestFields));
      FieldReader fields(head);
      McapAttachmentIndex index;
      index.offset = offset;
      index.length = kRecordPrefix + length;
      index.log_time = fields.u64();
      index.create_time = fields.u64();
      index.name = fields.text();
      index.media_type = fields.text();
      index.data_size = fields.u64();
      attachments_.push_back(std::move(index));
      ++statistics_.attachment_count;
      break;
    }
    case kMetadata:
      metadata_.push_back(decode_metadata(content()));
      ++statistics_.metadata_count;
      break;
    default:
      break;  // indexes are rebuilt; unknown records are allowed and skipped
  }
}

void McapReader::scan_block(std::uint8_t opcode, std::uint64_t offset, std::uint64_t length) {
  Block block{0, 0, offset, length, {}};
  const std::vector<McapMessage> messages = block_messages(block);
  for (const McapMessage& message : messages) {
    const bool first_of_all = statistics_.message_count == 0;
    const bool first_of_block = &message == &messages.front();
    block.start_time =
        first_of_block ? message.log_time : std::min(block.start_time, message.log_time);
    block.end_time = std::max(block.end_time, message.log_time);
    auto& start = statistics_.message_start_time;
    start = first_of_all ? message.log_time : std::min(start, message.log_time);
    statistics_.message_end_time = std::max(statistics_.message_end_time, message.log_time);
    ++statistics_.message_count;
    ++statistics_.channel_message_counts[message.channel_id];
  }
  statistics_.schema_count = static_cast<std::uint16_t>(schemas_.size());
  statistics_.channel_count = static_cast<std::uint32_t>(channels_.size());
  if (!messages.empty()) blocks_.push_back(block);
  if (opcode != kChunk) return;
  ++statistics_.chunk_count;
  McapChunkIndex chunk;
  chunk.message_start_time = block.start_time;
  chunk.message_end_time = block.end_time;
  chunk.chunk_start_offset = offset;
  chunk.chunk_length = length;
  chunks_.push_back(std::move(chunk));
}

}  // namespace prehend::recording
