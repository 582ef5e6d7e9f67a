// A recording: opened, every message of it and every attachment read, every schema understood and
// used.

#include <google/protobuf/message.h>

#include <cstdint>
#include <map>
#include <stdexcept>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/protobuf_schema.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/quiet_protobuf.h"

namespace {

using namespace prehend::recording;

// The channels' message types, as far as their schemas define any.
class Types {
 public:
  explicit Types(const McapReader& reader) {
    for (const auto& [id, channel] : reader.channels()) {
      const McapSchema* schema = reader.schema_of(channel);
      if (!schema) continue;
      try {
        factories_.try_emplace(id, schema->name, schema->data);
      } catch (const std::invalid_argument&) {
      }
    }
  }
  void parse(const McapMessage& message) const {
    const auto factory = factories_.find(message.channel_id);
    if (factory == factories_.end()) return;
    const auto content = factory->second.make();
    if (content->ParsePartialFromArray(message.data.data(), static_cast<int>(message.data.size())))
      content->ShortDebugString();
  }

 private:
  std::map<std::uint16_t, SchemaMessageFactory> factories_;
};

void read_messages(McapReader& reader) {
  const Types types(reader);
  McapMessageCursor cursor = reader.messages();
  std::uint64_t last = 0;
  while (const auto message = cursor.next()) {
    FUZZ_CHECK(reader.channels().count(message->channel_id) == 1);
    // A chunk that begins before its index says comes late, so only within one is the order sure.
    if (reader.chunks().size() <= 1) FUZZ_CHECK(message->log_time >= last);
    last = message->log_time;
    types.parse(*message);
  }
}

void read_attachments(const McapReader& reader) {
  for (const auto& index : reader.attachments()) {
    try {
      reader.read_attachment(index);
    } catch (const McapError&) {
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  prehend::fuzz::quiet_protobuf();
  const prehend::fuzz::MemoryFile file({reinterpret_cast<const char*>(data), size});
  try {
    McapReader reader(file.path(), {.largest_chunk = 1 << 20});
    read_messages(reader);
    read_attachments(reader);
  } catch (const McapError&) {
  }
  return 0;
}
