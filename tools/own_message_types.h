#pragma once

#include <string>

namespace google::protobuf {
class Descriptor;
}

namespace prehend::tools {

/// The message type of that full name among the ones of msgs/; nullptr when there is none.
const google::protobuf::Descriptor* own_message_type(const std::string& full_name);

}  // namespace prehend::tools
