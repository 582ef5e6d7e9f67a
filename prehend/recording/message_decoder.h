#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "prehend/recording/mcap_records.h"
#include "prehend/recording/protobuf_schema.h"

namespace prehend::recording {

/// Decodes recorded protobuf messages by the schemas of their recording.
class MessageDecoder {
 public:
  /// Makes a schema known; one that is not protobuf is passed over. Returns why it cannot be used;
  /// empty when it can.
  std::string add(const McapSchema& schema);

  bool knows(std::uint16_t schema_id) const { return factories_.count(schema_id) > 0; }

  /// The message, which must not outlive this object; nullptr when the schema is not known or the
  /// data are not such a message.
  std::unique_ptr<google::protobuf::Message> decode(std::uint16_t schema_id,
                                                    std::string_view data) const;

 private:
  std::map<std::uint16_t, std::unique_ptr<SchemaMessageFactory>> factories_;
};

}  // namespace prehend::recording
