#pragma once

#include <string>

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

/// Fills `message` from protobuf text or, when it begins with '{', from protobuf's JSON. Throws
/// std::runtime_error with the place and, for an unknown field or enumeration value, the nearest.
void parse_message(const std::string& text, google::protobuf::Message& message);

}  // namespace prehend::tools
