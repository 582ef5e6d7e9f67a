#include "nodes/replay/header_stamp.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>
#include <google/protobuf/wire_format_lite.h>

#include "msgs/geometry.pb.h"
#include "prehend/recording/protobuf_schema.h"

namespace prehend {

int header_field_of(const std::string& name, const std::string& descriptor_set) {
  const recording::SchemaMessageFactory factory(name, descriptor_set);
  const auto message = factory.make();
  const auto* field = message->GetDescriptor()->FindFieldByName("header");
  const bool is_header = field != nullptr && !field->is_repeated() &&
                         field->message_type() != nullptr &&
                         field->message_type()->full_name() == "prehend.msgs.Header";
  return is_header ? field->number() : 0;
}

std::int64_t header_stamp(std::string_view message, int header_field) {
  using google::protobuf::internal::WireFormatLite;
  if (header_field == 0) return 0;
  google::protobuf::io::CodedInputStream input(
      reinterpret_cast<const std::uint8_t*>(message.data()), static_cast<int>(message.size()));
  const auto wanted =
      WireFormatLite::MakeTag(header_field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED);
  while (const std::uint32_t tag = input.ReadTag()) {
    std::uint32_t length = 0;
    if (tag != wanted) {
      if (!WireFormatLite::SkipField(&input, tag)) return 0;
      continue;
    }
    msgs::Header header;
    std::string bytes;
    if (!input.ReadVarint32(&length) || !input.ReadString(&bytes, static_cast<int>(length)))
      return 0;
    return header.ParseFromString(bytes) ? header.stamp() : 0;
  }
  return 0;
}

}  // namespace prehend
