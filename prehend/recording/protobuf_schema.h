#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace prehend::recording {

/// Serialised google.protobuf.FileDescriptorSet with the file that defines `message` and everything
/// it imports, dependencies first, each file once: the data of a protobuf schema in MCAP.
std::string file_descriptor_set(const google::protobuf::Descriptor& message);

/// Makes messages of a type known only from its schema, e.g. one found in a recording.
class SchemaMessageFactory {
 public:
  /// `name`: full message name; `descriptor_set`: as above. Throws std::invalid_argument when the
  /// set cannot be read or does not define the message.
  SchemaMessageFactory(std::string_view name, std::string_view descriptor_set);
  ~SchemaMessageFactory();
  SchemaMessageFactory(const SchemaMessageFactory&) = delete;
  SchemaMessageFactory& operator=(const SchemaMessageFactory&) = delete;

  /// An empty message of the type. The factory must outlive it.
  std::unique_ptr<google::protobuf::Message> make() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace prehend::recording
