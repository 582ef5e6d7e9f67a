#include "prehend/recording/message_decoder.h"

#include <google/protobuf/message.h>

#include <limits>
#include <stdexcept>

namespace prehend::recording {

std::string MessageDecoder::add(const McapSchema& schema) {
  if (schema.encoding != "protobuf") return "";
  try {
    factories_[schema.id] = std::make_unique<SchemaMessageFactory>(schema.name, schema.data);
    return "";
  } catch (const std::invalid_argument& error) {
    factories_.erase(schema.id);
    return error.what();
  }
}

std::unique_ptr<google::protobuf::Message> MessageDecoder::decode(std::uint16_t schema_id,
                                                                  std::string_view data) const {
  const auto factory = factories_.find(schema_id);
  if (factory == factories_.end() || data.size() > std::numeric_limits<int>::max()) return nullptr;
  auto message = factory->second->make();
  if (!message->ParseFromArray(data.data(), static_cast<int>(data.size()))) return nullptr;
  return message;
}

}  // namespace prehend::recording
