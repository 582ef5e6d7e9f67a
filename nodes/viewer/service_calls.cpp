#include "nodes/viewer/service_calls.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "nodes/viewer/message_types.h"

namespace prehend::nodes {
namespace {

namespace protobuf_json = google::protobuf::util;

constexpr std::size_t kMostWaiting = 32;

void read_request(const std::string& encoding, const std::string& payload,
                  google::protobuf::Message& request) {
  if (encoding == "json") {
    const auto status = protobuf_json::JsonStringToMessage(payload, &request);
    if (status.ok()) return;
    throw std::runtime_error(
        fmt::format("this is no {}: {}", request.GetTypeName(), status.ToString()));
  }
  if (encoding != "protobuf") {
    throw std::runtime_error(
        fmt::format("requests are taken as protobuf or json, not as '{}'", encoding));
  }
  if (!request.ParseFromString(payload)) {
    throw std::runtime_error(fmt::format("this is no {}", request.GetTypeName()));
  }
}

std::string written(const std::string& encoding, const google::protobuf::Message& response) {
  if (encoding != "json") return response.SerializeAsString();
  protobuf_json::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = protobuf_json::MessageToJsonString(response, &text, options);
  if (!status.ok()) throw std::runtime_error(status.ToString());
  return text;
}

}  // namespace

void ServiceCalls::call(const viewing::ServiceType& service, const std::string& encoding,
                        const std::string& payload, Answer answer) {
  const bool taken = tasks_.post_unless_full(
      [this, service, encoding, payload, answer] {
        try {
          const auto request = make_message(service.request);
          const auto response = make_message(service.response);
          read_request(encoding, payload, *request);
          call_now(service.name, *request, *response, kCallTimeout);
          answer({"", encoding, written(encoding, *response)});
        } catch (const std::exception& error) {
          answer({fmt::format("service {}: {}", service.name, error.what()), "", ""});
        }
      },
      kMostWaiting);
  if (!taken) answer({"too many calls wait for their answers", "", ""});
}

void ServiceCalls::call_now(const std::string& service, const google::protobuf::Message& request,
                            google::protobuf::Message& response, std::chrono::nanoseconds timeout) {
  graph::RawServiceClient client;
  {
    const std::string key = fmt::format("{} {} {}", service, fmt::ptr(request.GetDescriptor()),
                                        fmt::ptr(response.GetDescriptor()));
    const std::lock_guard lock(mutex_);
    auto found = clients_.find(key);
    if (found == clients_.end()) {
      found = clients_
                  .emplace(key, node_.raw_client("/" + service, *request.GetDescriptor(),
                                                 *response.GetDescriptor()))
                  .first;
    }
    client = found->second;
  }
  std::string error;
  if (client.call(request, response, timeout, error) != graph::Status::kOk) {
    throw std::runtime_error(error);
  }
}

}  // namespace prehend::nodes
