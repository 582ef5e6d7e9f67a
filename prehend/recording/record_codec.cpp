#include "prehend/recording/record_codec.h"

#include <zlib.h>

#include <limits>

namespace prehend::recording {

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t crc) {
  if (bytes.empty()) return crc;  // zlib takes a null pointer for "start again"
  return static_cast<std::uint32_t>(
      crc32_z(crc, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

void FieldWriter::text(std::string_view value) {
  if (value.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw McapError("a text of " + std::to_string(value.size()) +
                    " bytes does not fit into an MCAP record (4 GiB at most)");
  }
  u32(static_cast<std::uint32_t>(value.size()));
  out_.append(value);
}

void FieldWriter::text_map(const std::map<std::string, std::string>& values) {
  std::string bytes;
  FieldWriter writer(bytes);
  for (const auto& [key, value] : values) {
    writer.text(key);
    writer.text(value);
  }
  text(bytes);
}

void FieldWriter::channel_map(const std::map<std::uint16_t, std::uint64_t>& values) {
  u32(static_cast<std::uint32_t>(values.size() * 10));
  for (const auto& [channel, value] : values) {
    u16(channel);
    u64(value);
  }
}

std::string_view FieldReader::raw(std::uint64_t count) {
  if (count > bytes_.size()) {
    throw McapError("a field of " + std::to_string(count) + " bytes runs past its record's end");
  }
  const std::string_view taken = bytes_.substr(0, count);
  bytes_.remove_prefix(count);
  return taken;
}

std::uint64_t FieldReader::number(std::size_t count) {
  const std::string_view bytes = raw(count);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  }
  return value;
}

std::map<std::string, std::string> FieldReader::text_map() {
  FieldReader entries(raw(u32()));
  std::map<std::string, std::string> values;
  while (!entries.rest().empty()) {
    std::string key = entries.text();
    values.insert_or_assign(std::move(key), entries.text());
  }
  return values;
}

std::map<std::uint16_t, std::uint64_t> FieldReader::channel_map() {
  FieldReader entries(raw(u32()));
  std::map<std::uint16_t, std::uint64_t> values;
  while (!entries.rest().empty()) {
    const std::uint16_t channel = entries.u16();
    values.insert_or_assign(channel, entries.u64());
  }
  return values;
}

void append_record(std::string& out, std::uint8_t opcode, std::string_view content) {
  FieldWriter writer(out);
  writer.u8(opcode);
  writer.u64(content.size());
  out.append(content);
}

std::string encode(const McapSchema& schema) {
  std::string out;
  FieldWriter writer(out);
  writer.u16(schema.id);
  writer.text(schema.name);
  writer.text(schema.encoding);
  writer.text(schema.data);
  return out;
}

McapSchema decode_schema(std::string_view content) {
  FieldReader reader(content);
  McapSchema schema;
  schema.id = reader.u16();
  schema.name = reader.text();
  schema.encoding = reader.text();
  schema.data = reader.text();
  return schema;
}

std::string encode(const McapChannel& channel) {
  std::string out;
  FieldWriter writer(out);
  writer.u16(channel.id);
  writer.u16(channel.schema_id);
  writer.text(channel.topic);
  writer.text(channel.message_encoding);
  writer.text_map(channel.metadata);
  return out;
}

McapChannel decode_channel(std::string_view content) {
  FieldReader reader(content);
  McapChannel channel;
  channel.id = reader.u16();
  channel.schema_id = reader.u16();
  channel.topic = reader.text();
  channel.message_encoding = reader.text();
  channel.metadata = reader.text_map();
  return channel;
}

std::string encode(const McapStatistics& statistics) {
  std::string out;
  FieldWriter writer(out);
  writer.u64(statistics.message_count);
  writer.u16(statistics.schema_count);
  writer.u32(statistics.channel_count);
  writer.u32(statistics.attachment_count);
  writer.u32(statistics.metadata_count);
  writer.u32(statistics.chunk_count);
  writer.u64(statistics.message_start_time);
  writer.u64(statistics.message_end_time);
  writer.channel_map(statistics.channel_message_counts);
  return out;
}

McapStatistics decode_statistics(std::string_view content) {
  FieldReader reader(content);
  McapStatistics statistics;
  statistics.message_count = reader.u64();
  statistics.schema_count = reader.u16();
  statistics.channel_count = reader.u32();
  statistics.attachment_count = reader.u32();
  statistics.metadata_count = reader.u32();
  statistics.chunk_count = reader.u32();
  statistics.message_start_time = reader.u64();
  statistics.message_end_time = reader.u64();
  statistics.channel_message_counts = reader.channel_map();
  return statistics;
}

std::string encode(const McapChunkIndex& index) {
  std::string out;
  FieldWriter writer(out);
  writer.u64(index.message_start_time);
  writer.u64(index.message_end_time);
  writer.u64(index.chunk_start_offset);
  writer.u64(index.chunk_length);
  writer.channel_map(index.message_index_offsets);
  writer.u64(index.message_index_length);
  writer.text(index.compression);
  writer.u64(index.compressed_size);
  writer.u64(index.uncompressed_size);
  return out;
}

McapChunkIndex decode_chunk_index(std::string_view content) {
  FieldReader reader(content);
  McapChunkIndex index;
  index.message_start_time = reader.u64();
  index.message_end_time = reader.u64();
  index.chunk_start_offset = reader.u64();
  index.chunk_length = reader.u64();
  index.message_index_offsets = reader.channel_map();
  index.message_index_length = reader.u64();
  index.compression = reader.text();
  index.compressed_size = reader.u64();
  index.uncompressed_size = reader.u64();
  return index;
}

std::string encode(const McapAttachmentIndex& index) {
  std::string out;
  FieldWriter writer(out);
  writer.u64(index.offset);
  writer.u64(index.length);
  writer.u64(index.log_time);
  writer.u64(index.create_time);
  writer.u64(index.data_size);
  writer.text(index.name);
  writer.text(index.media_type);
  return out;
}

McapAttachmentIndex decode_attachment_index(std::string_view content) {
  FieldReader reader(content);
  McapAttachmentIndex index;
  index.offset = reader.u64();
  index.length = reader.u64();
  index.log_time = reader.u64();
  index.create_time = reader.u64();
  index.data_size = reader.u64();
  index.name = reader.text();
  index.media_type = reader.text();
  return index;
}

std::string encode(const McapMetadata& metadata) {
  std::string out;
  FieldWriter writer(out);
  writer.text(metadata.name);
  writer.text_map(metadata.entries);
  return out;
}

McapMetadata decode_metadata(std::string_view content) {
  FieldReader reader(content);
  McapMetadata metadata;
  metadata.name = reader.text();
  metadata.entries = reader.text_map();
  return metadata;
}

}  // namespace prehend::recording
