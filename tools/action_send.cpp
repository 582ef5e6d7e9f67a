#include "tools/action_send.h"

#include <google/protobuf/message.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstdio>

#include "prehend/graph/introspection.h"
#include "prehend/recording/protobuf_schema.h"
#include "tools/command_node.h"
#include "tools/json.h"
#include "tools/message_input.h"
#include "tools/message_text.h"
#include "tools/said_outcome.h"

namespace prehend::tools {
namespace {

using graph::Status;
using recording::SchemaMessageFactory;
using std::chrono::steady_clock;

constexpr auto kTurn = std::chrono::milliseconds(50);

std::atomic<bool> interrupted = false;

void interrupt(int) { interrupted = true; }

// The first signal is noticed, a second one has its default effect.
void notice_interrupts() {
  struct sigaction action = {};
  action.sa_handler = interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
}

// The types of an action.
struct ActionTypes {
  explicit ActionTypes(const std::vector<graph::Schema>& types)
      : goal(types[0].name, types[0].descriptor_set),
        feedback(types[1].name, types[1].descriptor_set),
        result(types[2].name, types[2].descriptor_set) {}
  SchemaMessageFactory goal, feedback, result;
};

void print_feedback(const google::protobuf::Message& feedback, bool json) {
  if (json) return print(Json::object().set("feedback", json_of(feedback)));
  std::printf("feedback\n%s---\n", message_text(feedback, false).c_str());
  std::fflush(stdout);
}

// A goal that was not done counts as failed also where the handler says so in its result.
int print_end(Status status, const std::string& error, const google::protobuf::Message* result,
              bool json) {
  const SaidOutcome said =
      status == Status::kOk && result ? said_outcome(*result) : SaidOutcome{true, error};
  const bool done = status == Status::kOk && said.done;
  const std::string word = status != Status::kOk ? graph::to_string(status)
                           : said.done           ? (json ? "ok" : "done")
                                                 : "not done";
  if (json) {
    print(Json::object()
              .set("status", word)
              .set("error", said.reason)
              .set("result", result ? json_of(*result) : Json::null()));
  } else {
    std::printf("%s%s%s\n", word.c_str(), said.reason.empty() ? "" : ": ", said.reason.c_str());
    if (result) std::fputs(message_text(*result, false).c_str(), stdout);
  }
  return done ? 0 : 1;
}

}  // namespace

int send_goal(const SendOptions& options) {
  const ActionTypes types(graph::Introspection(options.registry).action(options.action));
  const auto goal = types.goal.make(), result = types.result.make();
  const auto feedback = types.feedback.make();
  parse_message(options.text, *goal);
  interrupted = false;
  notice_interrupts();
  graph::Node node(command_node("send", options.registry));
  const auto client = node.raw_action_client(options.action, *goal->GetDescriptor(),
                                             *feedback->GetDescriptor(), *result->GetDescriptor());
  const auto handle = client.send(*goal, [&](const std::string& bytes) {
    if (options.quiet) return;
    if (!feedback->ParseFromString(bytes)) throw std::runtime_error("feedback is damaged");
    print_feedback(*feedback, options.json);
  });
  const auto start = steady_clock::now();
  bool cancelled = false, has_result = false;
  std::string error;
  Status status = Status::kTimeout;
  while ((status = handle.wait(*result, has_result, kTurn, error)) == Status::kTimeout) {
    const std::chrono::duration<double> elapsed = steady_clock::now() - start;
    const bool late = options.timeout > 0 && elapsed.count() > options.timeout;
    if (cancelled || (!late && !interrupted)) continue;
    std::fprintf(stderr, "%s\n", late ? "the time is over, cancelling" : "cancelling");
    handle.cancel();
    cancelled = true;
  }
  return print_end(status, error, has_result || status == Status::kOk ? result.get() : nullptr,
                   options.json);
}

}  // namespace prehend::tools
