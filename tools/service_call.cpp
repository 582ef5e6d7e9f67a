#include "tools/service_call.h"

#include <google/protobuf/message.h>

#include <cstdio>
#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/recording/protobuf_schema.h"
#include "tools/command_node.h"
#include "tools/json.h"
#include "tools/message_input.h"
#include "tools/message_text.h"
#include "tools/said_outcome.h"

namespace prehend::tools {

int call_service(const CallOptions& options) {
  using recording::SchemaMessageFactory;
  const auto offer = graph::Introspection(options.registry).service(options.service);
  const SchemaMessageFactory request_type(offer[0].name, offer[0].descriptor_set);
  const SchemaMessageFactory response_type(offer[1].name, offer[1].descriptor_set);
  const auto request = request_type.make(), response = response_type.make();
  parse_message(options.text, *request);
  graph::Node node(command_node("call", options.registry));
  const auto client =
      node.raw_client(options.service, *request->GetDescriptor(), *response->GetDescriptor());
  std::string error;
  const auto timeout = std::chrono::nanoseconds(graph::nanoseconds(options.timeout));
  if (client.call(*request, *response, timeout, error) != graph::Status::kOk) {
    throw std::runtime_error(error);
  }
  if (options.json) {
    print(json_of(*response));
  } else {
    std::fputs(message_text(*response, false).c_str(), stdout);
  }
  const SaidOutcome said = said_outcome(*response);
  if (said.done) return 0;
  std::fflush(stdout);
  std::fprintf(stderr, "prehend: %s was not done: %s\n", options.service.c_str(),
               said.reason.c_str());
  return 1;
}

}  // namespace prehend::tools
