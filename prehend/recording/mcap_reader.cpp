#include "prehend/recording/mcap_reader.h"

#include <algorithm>

#include "prehend/recording/chunk_compression.h"
#include "prehend/recording/record_codec.h"

namespace prehend::recording {
namespace {

constexpr std::size_t kMostProblems = 200;

}  // namespace

McapReader::McapReader(const std::string& path, McapReaderOptions options)
    : file_(path), options_(options) {
  check_magic();
  read_header();
  if (!read_summary()) scan();
}

void McapReader::check_magic() const {
  if (file_.size() == 0) throw McapError(path() + " is empty: not an MCAP recording");
  const std::string magic = file_.read(0, std::min<std::uint64_t>(file_.size(), kMagic.size()));
  if (magic == kMagic) return;
  if (magic.size() == kMagic.size() && magic.starts_with(kMagic.substr(0, 5))) {
    throw McapError(path() + " is MCAP of version '" + magic[5] + "'; only version '0' is known");
  }
  if (magic.starts_with("#ROSBAG")) {
    throw McapError(path() + " is a bag of ROS 1: `prehend bag import` makes a recording of it");
  }
  throw McapError(path() + " is not an MCAP recording (it does not begin with the MCAP magic)");
}

void McapReader::read_header() {
  const std::uint64_t offset = kMagic.size();
  if (file_.size() < offset + kRecordPrefix) return;
  const std::string prefix = file_.read(offset, kRecordPrefix);
  FieldReader fields(prefix);
  if (fields.u8() != kHeader) {
    report("there is no Header record" + at_byte(offset));
    return;
  }
  const std::uint64_t length = fields.u64();
  if (length > file_.size() - offset - kRecordPrefix) return;  // the scan reports it
  try {
    const std::string content = file_.read(offset + kRecordPrefix, length);
    FieldReader header(content);
    profile_ = header.text();
    library_ = header.text();
  } catch (const McapError& error) {
    report("the Header record is damaged: " + std::string(error.what()));
  }
}

void McapReader::forget_contents() {
  schemas_.clear();
  channels_.clear();
  statistics_ = {};
  chunks_.clear();
  attachments_.clear();
  metadata_.clear();
  blocks_.clear();
}

void McapReader::report(const std::string& problem) {
  if (problems_.size() > kMostProblems) return;
  if (std::find(problems_.begin(), problems_.end(), problem) != problems_.end()) return;
  problems_.push_back(problems_.size() == kMostProblems ? "further problems are not listed"
                                                        : problem);
}

const McapSchema* McapReader::schema_of(const McapChannel& channel) const {
  const auto found = schemas_.find(channel.schema_id);
  return found == schemas_.end() ? nullptr : &found->second;
}

void McapReader::take_schema(McapSchema schema) {
  if (schema.id == 0) throw McapError("a schema has the reserved id 0");
  const auto [known, is_new] = schemas_.try_emplace(schema.id, schema);
  if (!is_new && known->second != schema) {
    report("two schemas have the id " + std::to_string(schema.id) + ": " + known->second.name +
           " (kept) and " + schema.name);
  }
}

void McapReader::take_channel(McapChannel channel) {
  const auto [known, is_new] = channels_.try_emplace(channel.id, channel);
  if (!is_new && known->second != channel) {
    report("two channels have the id " + std::to_string(channel.id) + ": " + known->second.topic +
           " (kept) and " + channel.topic);
  }
}

std::vector<McapMessage> McapReader::block_messages(const Block& block) {
  std::vector<McapMessage> messages;
  try {
    std::string bytes = file_.read(block.offset, block.length);
    FieldReader record(bytes);
    const std::uint8_t opcode = record.u8();
    const std::uint64_t declared = record.u64();
    const std::uint64_t available = block.length - kRecordPrefix;
    const bool cut_off = declared > available && block.offset + block.length == file_.size();
    if ((opcode != kChunk && opcode != kMessage) || (declared != available && !cut_off)) {
      throw McapError("there is no such record, the index is wrong or the file damaged");
    }
    if (opcode == kChunk) {
      auto records = std::make_shared<const std::string>(chunk_records(record.rest(), cut_off));
      take_inner_records(block.offset, std::move(records), cut_off, messages);
    } else if (!cut_off) {
      const auto storage = std::make_shared<const std::string>(std::move(bytes));
      take_message(block.offset, std::string_view(*storage).substr(kRecordPrefix), storage,
                   messages);
    }
  } catch (const McapError& error) {
    report("skipped the chunk" + at_byte(block.offset) + ": " + error.what());
  }
  return messages;
}

std::string McapReader::chunk_records(std::string_view content, bool cut_off) const {
  FieldReader fields(content);
  fields.u64();  // the message times are taken from the messages
  fields.u64();
  const std::uint64_t uncompressed_size = fields.u64();
  const std::uint32_t crc = fields.u32();
  const std::string compression = fields.text();
  const std::uint64_t stored_size = fields.u64();
  if (cut_off) {
    if (!compression.empty()) throw McapError("it is compressed and cut off");
    return std::string(fields.rest());
  }
  if (uncompressed_size > options_.largest_chunk) {
    throw McapError("it declares " + std::to_string(uncompressed_size) +
                    " uncompressed bytes, more than the allowed " +
                    std::to_string(options_.largest_chunk));
  }
  std::string records =
      decompress(compression, std::string(fields.raw(stored_size)), uncompressed_size);
  if (crc != 0 && crc32_of(records) != crc) throw McapError("its checksum is wrong");
  return records;
}

void McapReader::take_inner_records(std::uint64_t chunk_offset,
                                    std::shared_ptr<const std::string> records, bool cut_off,
                                    std::vector<McapMessage>& messages) {
  FieldReader reader(*records);
  while (reader.rest().size() >= kRecordPrefix) {
    const std::uint8_t opcode = reader.u8();
    const std::uint64_t length = reader.u64();
    if (length > reader.rest().size()) {
      if (!cut_off) report("the chunk" + at_byte(chunk_offset) + " ends inside a record");
      return;
    }
    try {
      const std::string_view content = reader.raw(length);
      if (opcode == kSchema) take_schema(decode_schema(content));
      if (opcode == kChannel) take_channel(decode_channel(content));
      if (opcode == kMessage) take_message(chunk_offset, content, records, messages);
    } catch (const McapError& error) {
      report("a record inside the chunk" + at_byte(chunk_offset) + " is damaged: " + error.what());
    }
  }
  if (!cut_off && !reader.rest().empty()) {
    report("the chunk" + at_byte(chunk_offset) + " ends inside a record");
  }
}

void McapReader::take_message(std::uint64_t offset, std::string_view content,
                              const std::shared_ptr<const std::string>& storage,
                              std::vector<McapMessage>& messages) {
  FieldReader fields(content);
  McapMessage message;
  message.channel_id = fields.u16();
  message.sequence = fields.u32();
  message.log_time = fields.u64();
  message.publish_time = fields.u64();
  message.data = fields.rest();
  message.storage = storage;
  if (channels_.count(message.channel_id) == 0) {
    report("messages" + at_byte(offset) + " were skipped: they are of channel " +
           std::to_string(message.channel_id) + ", which is not declared");
    return;
  }
  messages.push_back(std::move(message));
}

McapAttachment McapReader::read_attachment(const McapAttachmentIndex& index) const {
  const std::string bytes = file_.read(index.offset, index.length);
  FieldReader record(bytes);
  if (record.u8() != kAttachment || record.u64() != record.rest().size()) {
    throw McapError("there is no attachment" + at_byte(index.offset) + " of " + path());
  }
  const std::string_view content = record.rest();
  McapAttachment attachment;
  attachment.log_time = record.u64();
  attachment.create_time = record.u64();
  attachment.name = record.text();
  attachment.media_type = record.text();
  attachment.data = std::string(record.raw(record.u64()));
  const std::string_view covered = content.substr(0, content.size() - record.rest().size());
  const std::uint32_t crc = record.u32();
  if (crc != 0 && crc32_of(covered) != crc) {
    throw McapError("the attachment " + attachment.name + " of " + path() +
                    " is damaged: its checksum is wrong");
  }
  return attachment;
}

}  // namespace prehend::recording
