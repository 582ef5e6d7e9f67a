#include "tools/json.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <cstdio>
#include <stdexcept>
#include <utility>

namespace prehend::tools {

Json json_of(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(message, &json, options);
  if (!status.ok()) {
    throw std::runtime_error("a " + message.GetTypeName() +
                             " cannot be said in JSON: " + status.ToString());
  }
  return Json::said(std::move(json));
}

void print(const Json& json) {
  std::printf("%s\n", json.text().c_str());
  std::fflush(stdout);
}

}  // namespace prehend::tools
