#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/viewing/websocket_client.h"

namespace prehend::nodes {

/// What a viewer was told, followed until something is there.
class Looking {
 public:
  explicit Looking(std::uint16_t port, int receive_buffer = 0)
      : client_(port, options_of(receive_buffer)) {}

  bool until(const std::function<bool()>& condition,
             std::chrono::seconds patience = std::chrono::seconds(10)) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      if (const auto frame = client_.receive(std::chrono::milliseconds(50))) take(*frame);
    }
    return true;
  }
  bool has(const std::string& topic) {
    return until([&] { return channels.count(topic) > 0; });
  }
  void say(const nlohmann::json& object) { client_.send_text(object.dump()); }
  void subscribe(const std::string& topic, int id) {
    say({{"op", "subscribe"},
         {"subscriptions", {{{"id", id}, {"channelId", channels.at(topic)}}}}});
  }
  // The answer's JSON, or the failure's words.
  std::string call(const std::string& service, const std::string& request) {
    if (!until([&] { return services.count(service) > 0; })) return "no such service";
    answer.reset();
    std::string bytes("\x02", 1);
    const auto add = [&](std::uint32_t number) {
      for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xff);
    };
    add(services.at(service));
    add(1);
    add(4);
    client_.send_binary(bytes + "json" + request);
    until([&] { return answer.has_value(); });
    return answer.value_or("no answer");
  }

  std::map<std::string, std::uint32_t> channels, services;
  std::map<int, std::vector<std::string>> messages;  // payloads by subscription
  std::vector<std::string> statuses;
  std::map<std::string, nlohmann::json> parameters;
  nlohmann::json info, graph;
  std::optional<std::string> answer;
  int times = 0;

 private:
  static testing::WebSocketClient::Options options_of(int receive_buffer) {
    testing::WebSocketClient::Options options;
    options.receive_buffer = receive_buffer;
    return options;
  }
  void take(const testing::WebSocketClient::Frame& frame) {
    if (!frame.is_text) return take_binary(frame.bytes);
    const nlohmann::json object = nlohmann::json::parse(frame.bytes);
    const std::string op = object["op"];
    if (op == "serverInfo") info = object;
    if (op == "connectionGraphUpdate") graph = object;
    if (op == "status") statuses.push_back(object["message"]);
    if (op == "serviceCallFailure") answer = object["message"];
    if (op == "parameterValues") {
      for (const nlohmann::json& one : object["parameters"]) parameters[one["name"]] = one["value"];
    }
    if (op == "advertise") {
      for (const nlohmann::json& one : object["channels"]) channels[one["topic"]] = one["id"];
    }
    if (op == "advertiseServices") {
      for (const nlohmann::json& one : object["services"]) services[one["name"]] = one["id"];
    }
    if (op == "unadvertise") {
      for (const nlohmann::json& id : object["channelIds"]) {
        std::erase_if(channels, [&](const auto& one) { return one.second == id; });
      }
    }
  }
  void take_binary(const std::string& bytes) {
    if (bytes[0] == 1) messages[bytes[1]].push_back(bytes.substr(13));
    if (bytes[0] == 2) ++times;
    if (bytes[0] == 3) answer = bytes.substr(13 + 4);
  }

  testing::WebSocketClient client_;
};

}  // namespace prehend::nodes
