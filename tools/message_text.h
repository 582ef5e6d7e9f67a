#pragma once

#include <string>

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

/// A message as protobuf text. Unless `full`, byte and text fields beyond 64 bytes and repeated
/// numbers beyond 16 are cut short and their size is said.
std::string message_text(const google::protobuf::Message& message, bool full);

}  // namespace prehend::tools
