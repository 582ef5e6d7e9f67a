#include "prehend/recording/ros1_bag.h"

#include <bzlib.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "prehend/recording/chunk_compression.h"
#include "prehend/recording/mcap_records.h"
#include "prehend/recording/record_codec.h"

namespace prehend::recording {
namespace {

constexpr std::string_view kBegin = "#ROSBAG V";
constexpr std::string_view kMagic2 = "#ROSBAG V2.0\n";
constexpr std::uint64_t kLargestChunk = std::uint64_t{1} << 30;  // bytes, uncompressed

enum Operation : std::uint8_t { kMessageData = 0x02, kChunkRecord = 0x05, kConnection = 0x07 };

// name=value, each with its length before it.
std::map<std::string, std::string_view> fields_of(std::string_view bytes) {
  std::map<std::string, std::string_view> fields;
  FieldReader reader(bytes);
  while (!reader.rest().empty()) {
    const std::string_view field = reader.raw(reader.u32());
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) throw McapError("a header field has no '='");
    fields[std::string(field.substr(0, equals))] = field.substr(equals + 1);
  }
  return fields;
}

std::string_view field(const std::map<std::string, std::string_view>& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end()) {
    throw McapError(std::string("a header has no field '") + name + "'");
  }
  return found->second;
}

std::uint8_t operation_of(const std::map<std::string, std::string_view>& header) {
  return FieldReader(field(header, "op")).u8();
}

std::string from_bzip2(std::string_view bytes, std::uint64_t size) {
  std::string result(size, '\0');
  auto length = static_cast<unsigned>(size);
  // The library's interface knows no const; it only reads.
  const int code = BZ2_bzBuffToBuffDecompress(result.data(), &length,
                                              const_cast<char*>(bytes.data()),  // NOLINT
                                              static_cast<unsigned>(bytes.size()), 0, 0);
  if (code != BZ_OK || length != size) throw McapError("its bzip2 data are damaged");
  return result;
}

}  // namespace

bool Ros1BagReader::is_bag(const std::string& path) {
  const ByteFile file(path);
  return file.size() >= kBegin.size() && file.read(0, kBegin.size()) == kBegin;
}

Ros1BagReader::Ros1BagReader(const std::string& path) : file_(path) {
  const auto length = std::min<std::uint64_t>(file_.size(), kMagic2.size());
  const std::string magic = file_.read(0, length);
  if (magic != kMagic2) {
    const bool is_old = magic.compare(0, kBegin.size(), kBegin) == 0;
    throw McapError("'" + path + "' is " +
                    (is_old ? "a ROS bag of an older format; mend it with 'rosbag fix'"
                            : "no ROS bag: it does not begin with #ROSBAG V2.0"));
  }
  position_ = kMagic2.size();
}

void Ros1BagReader::report(std::uint64_t offset, const std::string& what) {
  const std::string problem = file_.path() + at_byte(offset) + ": " + what;
  if (std::find(problems_.begin(), problems_.end(), problem) == problems_.end()) {
    problems_.push_back(problem);
  }
}

std::optional<Ros1Message> Ros1BagReader::next() {
  while (true) {
    while (chunk_position_ < chunk_.size()) {
      try {
        FieldReader reader(std::string_view(chunk_).substr(chunk_position_));
        Record record;
        record.header = fields_of(reader.raw(reader.u32()));
        record.data = reader.raw(reader.u32());
        chunk_position_ = chunk_.size() - reader.rest().size();
        if (const auto message = take(record)) return message;
      } catch (const McapError& error) {
        report(chunk_offset_, std::string("the rest of this chunk is left out: ") + error.what());
        chunk_position_ = chunk_.size();
      }
    }
    if (!load_chunk()) return std::nullopt;
  }
}

// Goes on to the next chunk; false at the end. Messages outside of chunks are one.
bool Ros1BagReader::load_chunk() {
  while (position_ + 8 <= file_.size()) {
    const std::uint64_t at = position_;
    try {
      const auto length_at = [&](std::uint64_t place) {
        const std::string bytes = file_.read(place, 4);
        return FieldReader(bytes).u32();
      };
      const std::uint32_t header_length = length_at(at);
      const std::string header_bytes = file_.read(at + 4, header_length);
      const Fields header = fields_of(header_bytes);
      const std::uint64_t data_at = at + 8 + header_length;
      const std::uint32_t data_length = length_at(at + 4 + header_length);
      if (data_at + data_length > file_.size()) {
        throw McapError("the file ends within a record: it was cut off, or never closed");
      }
      position_ = data_at + data_length;
      const std::uint8_t operation = operation_of(header);
      if (operation == kConnection || operation == kMessageData) {
        outside_ = file_.read(at, 8 + header_length + data_length);
        chunk_ = outside_;
        chunk_position_ = 0;
        chunk_offset_ = at;
        return true;
      }
      if (operation != kChunkRecord) continue;  // indexes, and the bag's header
      const std::uint32_t size = FieldReader(field(header, "size")).u32();
      if (size > kLargestChunk) throw McapError("a chunk of more than 1 GiB is left out");
      std::string data = file_.read(data_at, data_length);
      const std::string_view compression = field(header, "compression");
      if (compression == "none") {
        chunk_ = std::move(data);
      } else if (compression == "bz2") {
        chunk_ = from_bzip2(data, size);
      } else {
        chunk_ = decompress(compression, std::move(data), size);
      }
      chunk_position_ = 0;
      chunk_offset_ = at;
      return true;
    } catch (const McapError& error) {
      report(at, error.what());
      if (position_ == at) break;  // where the next one begins is not known
    }
  }
  position_ = file_.size();
  return false;
}

std::optional<Ros1Message> Ros1BagReader::take(const Record& record) {
  const std::uint8_t operation = operation_of(record.header);
  if (operation == kConnection) {
    take_connection(record);
  } else if (operation == kMessageData) {
    Ros1Message message;
    message.connection = FieldReader(field(record.header, "conn")).u32();
    FieldReader time(field(record.header, "time"));
    const std::uint64_t seconds = time.u32();
    message.time = 1'000'000'000 * seconds + time.u32();
    message.data = record.data;
    if (connections_.count(message.connection) != 0) return message;
    report(chunk_offset_, "messages of a connection that is not described are left out");
  }
  return std::nullopt;
}

void Ros1BagReader::take_connection(const Record& record) {
  const Fields about = fields_of(record.data);
  Ros1Connection connection;
  connection.topic = field(record.header, "topic");
  connection.type = field(about, "type");
  connection.definition = field(about, "message_definition");
  connections_[FieldReader(field(record.header, "conn")).u32()] = std::move(connection);
}

}  // namespace prehend::recording
