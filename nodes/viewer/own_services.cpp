#include "nodes/viewer/own_services.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "msgs/actions.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/safety.pb.h"
#include "prehend/graph/clock.h"
#include "prehend/graph/clock_control.h"
#include "prehend/text/json.h"

namespace prehend::nodes {
namespace {

using nlohmann::json;
using std::chrono::seconds;

constexpr const char* kStop = "/emergency_stop/stop";
constexpr const char* kReset = "/emergency_stop/reset";
constexpr const char* kCycleStart = "/cycle/start";
constexpr const char* kCycleNode = "grasp_cycle";

std::string said(bool ok, const std::string& message) {
  return text::Json::object().set("ok", ok).set("message", message).text();
}

std::string said(const msgs::Acknowledge& answer) {
  return said(answer.success(), answer.reason());
}

// What cannot be done is an answer, too.
std::function<std::string(const std::string&)> answering(
    std::function<std::string(const std::string&)> work) {
  return [work = std::move(work)](const std::string& request) {
    try {
      return work(request);
    } catch (const std::exception& error) {
      return said(false, error.what());
    }
  };
}

json parsed(const std::string& request) {
  json object = json::parse(request.empty() ? "{}" : request, nullptr, false);
  if (object.is_discarded() || !object.is_object()) {
    throw std::invalid_argument("the request is to be a JSON object");
  }
  return object;
}

double number_of(const json& object, const char* name) {
  if (!object[name].is_number()) {
    throw std::invalid_argument(fmt::format("'{}' is to be a number", name));
  }
  return object[name].get<double>();
}

viewing::ServiceType json_service(const std::string& name, const std::string& request_schema,
                                  const std::string& response_schema) {
  const auto type = [&](const char* part, const std::string& schema) {
    return viewing::MessageType{"json", name + part, "jsonschema", schema};
  };
  return {name, name, type(".request", request_schema), type(".response", response_schema)};
}

constexpr const char* kAnswerSchema =
    R"({"type":"object","properties":{"ok":{"type":"boolean"},"message":{"type":"string"}}})";

std::string stop(ServiceCalls& calls, const std::string& request) {
  const json object = parsed(request);
  msgs::EmergencyStopRequest message;
  message.set_source("viewer");
  const auto reason = object.find("reason");
  message.set_reason(reason != object.end() && reason->is_string()
                         ? reason->get<std::string>()
                         : "somebody pressed stop in a viewer");
  msgs::Acknowledge answer;
  calls.call_now(kStop, message, answer, seconds(2));
  return said(answer);
}

std::string reset(ServiceCalls& calls) {
  msgs::Acknowledge answer;
  calls.call_now(kReset, msgs::Empty(), answer, seconds(2));
  return said(answer);
}

std::string control_simulation(ServiceCalls& calls, const std::string& request) {
  using Request = msgs::graph::ClockControlRequest;
  const json object = parsed(request);
  if (object.size() != 1) {
    throw std::invalid_argument(R"(one of {"pause": true}, {"step": 0.1}, {"speed": 1} is asked)");
  }
  Request message;
  if (object.contains("pause")) {
    if (!object["pause"].is_boolean())
      throw std::invalid_argument("'pause' is to be true or false");
    message.set_command(object["pause"].get<bool>() ? Request::PAUSE : Request::RESUME);
  } else if (object.contains("step")) {
    message.set_command(Request::STEP);
    message.set_step(graph::nanoseconds(number_of(object, "step")));
  } else if (object.contains("speed")) {
    message.set_command(Request::SET_SPEED);
    message.set_speed(number_of(object, "speed"));
  } else {
    throw std::invalid_argument("'" + object.begin().key() + "' is unknown: pause, step or speed");
  }
  msgs::graph::ClockControlResponse answer;
  calls.call_now(graph::kClockControlService, message, answer, seconds(5));
  if (!answer.error().empty()) return said(false, answer.error());
  return said(true,
              fmt::format("{} at {:.3f} s, speed {:g}", answer.paused() ? "paused" : "running",
                          graph::seconds(answer.time()), answer.speed()));
}

std::string execute(ServiceCalls& calls, Parameters& parameters, const std::string& request) {
  const json object = parsed(request);
  const auto whole = [&object](const char* name, const char* what) -> std::int64_t {
    const double number = number_of(object, name);
    if (number != std::floor(number) || number < -1 || number > 1e9) {
      throw std::invalid_argument(fmt::format("'{}' is to be {}", name, what));
    }
    return static_cast<std::int64_t>(number);
  };
  if (object.contains("grasp") && !object.contains("object")) {
    throw std::invalid_argument("'grasp' is of an object: give 'object', too");
  }
  if (object.contains("object")) {
    // Of an object alone its grasps as the plan has them.
    const std::int64_t grasp =
        object.contains("grasp") ? whole("grasp", "a grasp's rank, from 0") : -1;
    const auto answer =
        parameters.set({{viewed_name(kCycleNode, "object"), whole("object", "an object's number")},
                        {viewed_name(kCycleNode, "grasp"), grasp}});
    if (!answer.error.empty()) return said(false, answer.error);
  }
  msgs::Acknowledge answer;
  calls.call_now(kCycleStart, msgs::Empty(), answer, seconds(5));
  return said(answer);
}

}  // namespace

std::vector<OwnService> own_services(ServiceCalls& calls, Parameters& parameters) {
  std::vector<OwnService> services;
  services.push_back(
      {json_service("/viewer/stop",
                    R"({"type":"object","properties":{"reason":{"type":"string"}}})",
                    kAnswerSchema),
       {kStop},
       false,
       answering([&calls](const std::string& request) { return stop(calls, request); })});
  services.push_back({json_service("/viewer/reset_stop", R"({"type":"object"})", kAnswerSchema),
                      {kReset},
                      false,
                      answering([&calls](const std::string&) { return reset(calls); })});
  services.push_back(
      {json_service("/viewer/simulation",
                    R"({"type":"object","properties":{"pause":{"type":"boolean"},)"
                    R"("step":{"type":"number","description":"s"},"speed":{"type":"number"}}})",
                    kAnswerSchema),
       {graph::kClockControlService},
       false,
       answering(
           [&calls](const std::string& request) { return control_simulation(calls, request); })});
  services.push_back({json_service("/viewer/execute",
                                   R"({"type":"object","properties":{"object":{"type":"integer"},)"
                                   R"("grasp":{"type":"integer"}}})",
                                   kAnswerSchema),
                      {kCycleStart},
                      true,
                      answering([&calls, &parameters](const std::string& request) {
                        return execute(calls, parameters, request);
                      })});
  services.push_back({json_service("/viewer/describe_parameters", R"({"type":"object"})",
                                   R"({"type":"array","items":{"type":"object"}})"),
                      {},
                      true,
                      [&parameters](const std::string&) { return parameters.described(); }});
  return services;
}

}  // namespace prehend::nodes
