#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "prehend/graph/introspection.h"
#include "prehend/viewing/types.h"

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace prehend::nodes {

/// A message type that nodes have declared, as viewers are told of it. @throws std::runtime_error
/// when nobody answers.
viewing::MessageType viewed_type(graph::Introspection& graph, const std::string& name,
                                 std::uint64_t hash);

/// Of a generated type.
viewing::MessageType viewed_type(const google::protobuf::Descriptor& descriptor);

/// An empty message of such a type. Types are kept for the process' life, as clients of services
/// need; the same bytes give the same one. @throws std::invalid_argument for a damaged schema.
std::unique_ptr<google::protobuf::Message> make_message(const viewing::MessageType& type);

}  // namespace prehend::nodes
