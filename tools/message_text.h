#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace prehend::tools {

/// A list, or a text or bytes, that was cut short.
struct Shortened {
  std::string field;     ///< "objects[1].cloud.data"
  std::size_t size = 0;  ///< it had: elements, or bytes
  bool is_list = false;
  bool is_numbers = false;  ///< a list of numbers, which stands on one line as text
};

/// Cuts every list of the message and what it holds to its first `most_elements`, every text and
/// bytes field to its first `most_bytes`. Returns what was cut, in the order of the fields.
std::vector<Shortened> shorten(google::protobuf::Message& message, std::size_t most_elements,
                               std::size_t most_bytes);

/// A message as protobuf text. Unless `full`, byte fields beyond 64 bytes, text beyond 256 and
/// lists beyond 16 are cut short and their size is said.
std::string message_text(const google::protobuf::Message& message, bool full);

}  // namespace prehend::tools
