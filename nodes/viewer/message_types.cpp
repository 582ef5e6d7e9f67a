#include "nodes/viewer/message_types.h"

#include <google/protobuf/message.h>

#include <map>
#include <mutex>
#include <utility>

#include "prehend/recording/protobuf_schema.h"

namespace prehend::nodes {

viewing::MessageType viewed_type(graph::Introspection& graph, const std::string& name,
                                 std::uint64_t hash) {
  return {"protobuf", name, "protobuf", graph.schema(name, hash).descriptor_set};
}

viewing::MessageType viewed_type(const google::protobuf::Descriptor& descriptor) {
  return {"protobuf", descriptor.full_name(), "protobuf",
          recording::file_descriptor_set(descriptor)};
}

std::unique_ptr<google::protobuf::Message> make_message(const viewing::MessageType& type) {
  using Key = std::pair<std::string, std::string>;
  using Factory = recording::SchemaMessageFactory;
  static std::mutex mutex;
  static auto& factories = *new std::map<Key, std::unique_ptr<Factory>>();  // never destroyed
  const std::lock_guard lock(mutex);
  auto& factory = factories[{type.schema_name, type.schema}];
  if (!factory) factory = std::make_unique<Factory>(type.schema_name, type.schema);
  return factory->make();
}

}  // namespace prehend::nodes
