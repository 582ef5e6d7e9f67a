#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace google::protobuf {
class Descriptor;
}

namespace prehend::graph {

/// A message type, complete enough to decode or record messages without its generated code.
struct Schema {
  std::string name;            ///< full protobuf name, e.g. "prehend.msgs.PointCloud"
  std::uint64_t hash = 0;      ///< structural hash: 64-bit FNV-1a of names, numbers, types of all
                               ///< fields and enum values reachable from the message
  std::string descriptor_set;  ///< serialised google.protobuf.FileDescriptorSet, dependencies first
};

/// The schema of a generated message type. Computed once per type and kept for the process' life.
std::shared_ptr<const Schema> schema_of(const google::protobuf::Descriptor& descriptor);

/// The schema of message type `name` from a serialised FileDescriptorSet, e.g. of a recording.
/// Throws std::invalid_argument when the set is damaged, incomplete or lacks the type.
std::shared_ptr<const Schema> schema_from_descriptor_set(const std::string& name,
                                                         const std::string& descriptor_set);

}  // namespace prehend::graph
