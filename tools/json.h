#pragma once

#include "prehend/text/json.h"

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

using text::Json;

/// Protobuf's own JSON, with the field names of the .proto file and fields at their defaults, too.
/// @throws std::runtime_error naming the message's type when JSON cannot say it.
Json json_of(const google::protobuf::Message& message);

/// Prints it and a line's end, at once.
void print(const Json& json);

}  // namespace prehend::tools
