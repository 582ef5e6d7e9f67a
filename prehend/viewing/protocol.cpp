#include "prehend/viewing/protocol.h"

#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "prehend/text/json.h"
#include "prehend/text/nearest_match.h"

namespace prehend::viewing {
namespace {

using nlohmann::json;
using text::Json;

constexpr char kMessageData = 0x01, kTime = 0x02, kServiceResponse = 0x03, kAssetResponse = 0x04;
constexpr char kClientMessage = 0x01, kServiceRequest = 0x02;

// What a viewer sent, cut to what fits a line.
std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  return "'" + std::string(text.substr(0, kLongest)) + (text.size() > kLongest ? "...'" : "'");
}

// --- JSON of a viewer ---------------------------------------------------------------------------

const json& member(const json& object, const char* name) {
  if (!object.is_object())
    throw ProtocolError(fmt::format("what has '{}' is no JSON object", name));
  const auto found = object.find(name);
  if (found == object.end()) throw ProtocolError(fmt::format("'{}' is missing", name));
  return *found;
}

std::uint32_t number(const json& value, const char* name) {
  if (value.is_number_unsigned() &&
      value.get<std::uint64_t>() <= std::numeric_limits<std::uint32_t>::max()) {
    return value.get<std::uint32_t>();
  }
  throw ProtocolError(fmt::format("'{}' is to be a number from 0 to 2^32 - 1", name));
}

std::string word(const json& value, const char* name) {
  if (!value.is_string()) throw ProtocolError(fmt::format("'{}' is to be a text", name));
  return value.get<std::string>();
}

std::string word_if_any(const json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() || found->is_null() ? "" : word(*found, name);
}

const json& list(const json& object, const char* name) {
  const json& value = member(object, name);
  if (!value.is_array()) throw ProtocolError(fmt::format("'{}' is to be an array", name));
  return value;
}

std::vector<std::uint32_t> numbers(const json& object, const char* name) {
  std::vector<std::uint32_t> values;
  for (const json& value : list(object, name)) values.push_back(number(value, name));
  return values;
}

std::vector<std::string> words(const json& object, const char* name) {
  std::vector<std::string> values;
  for (const json& value : list(object, name)) values.push_back(word(value, name));
  return values;
}

std::optional<std::string> id_of(const json& object) {
  const auto found = object.find("id");
  if (found == object.end() || found->is_null()) return std::nullopt;
  return word(*found, "id");
}

ClientChannel client_channel(const json& value) {
  ClientChannel channel;
  channel.id = number(member(value, "id"), "id");
  channel.topic = word(member(value, "topic"), "topic");
  channel.type.encoding = word(member(value, "encoding"), "encoding");
  channel.type.schema_name = word_if_any(value, "schemaName");
  channel.type.schema_encoding = word_if_any(value, "schemaEncoding");
  channel.type.schema = word_if_any(value, "schema");
  if (channel.type.encoding == "protobuf") channel.type.schema_encoding = "protobuf";
  if (channel.type.schema_encoding == "protobuf") {
    channel.type.schema = from_base64(channel.type.schema);
  }
  return channel;
}

Value array_value(const std::string& name, const json& value, bool real) {
  std::vector<double> reals;
  std::vector<std::string> texts;
  for (const json& element : value) {
    if (element.is_number()) reals.push_back(element.get<double>());
    if (element.is_string()) texts.push_back(element.get<std::string>());
  }
  if (reals.size() == value.size() && (real || !value.empty())) return reals;
  if (texts.size() == value.size()) return texts;
  throw ProtocolError(
      fmt::format("the value of {} is to be an array of numbers or of texts", in_quotes(name)));
}

Parameter parameter(const json& object) {
  Parameter result{word(member(object, "name"), "name"), {}};
  const auto found = object.find("value");
  if (found == object.end() || found->is_null()) return result;
  const std::string type = word_if_any(object, "type");
  const json& value = *found;
  if (value.is_boolean()) {
    result.value = value.get<bool>();
  } else if (value.is_number_integer() && type != "float64" &&
             (!value.is_number_unsigned() ||
              value.get<std::uint64_t>() <= std::numeric_limits<std::int64_t>::max())) {
    result.value = value.get<std::int64_t>();
  } else if (value.is_number()) {
    result.value = value.get<double>();
  } else if (value.is_string()) {
    result.value =
        type == "byte_array" ? from_base64(value.get<std::string>()) : value.get<std::string>();
  } else if (value.is_array()) {
    result.value = array_value(result.name, value, type == "float64_array");
  } else {
    throw ProtocolError(
        fmt::format("the value of {} is of no type that parameters have", in_quotes(result.name)));
  }
  return result;
}

Request subscribe(const json& object) {
  Subscribe request;
  for (const json& one : list(object, "subscriptions")) {
    request.subscriptions.push_back(
        {number(member(one, "id"), "id"), number(member(one, "channelId"), "channelId")});
  }
  return request;
}

Request advertise(const json& object) {
  AdvertiseClient request;
  for (const json& one : list(object, "channels")) request.channels.push_back(client_channel(one));
  return request;
}

Request set_parameters(const json& object) {
  SetParameters request{{}, id_of(object)};
  for (const json& one : list(object, "parameters")) request.parameters.push_back(parameter(one));
  return request;
}

using Parser = Request (*)(const json&);
const std::vector<std::pair<std::string, Parser>>& parsers() {
  static const std::vector<std::pair<std::string, Parser>> kParsers{
      {"subscribe", subscribe},
      {"unsubscribe",
       [](const json& o) -> Request { return Unsubscribe{numbers(o, "subscriptionIds")}; }},
      {"advertise", advertise},
      {"unadvertise",
       [](const json& o) -> Request { return UnadvertiseClient{numbers(o, "channelIds")}; }},
      {"getParameters",
       [](const json& o) -> Request {
         return GetParameters{words(o, "parameterNames"), id_of(o)};
       }},
      {"setParameters", set_parameters},
      {"subscribeParameterUpdates",
       [](const json& o) -> Request { return SubscribeParameters{words(o, "parameterNames")}; }},
      {"unsubscribeParameterUpdates",
       [](const json& o) -> Request { return UnsubscribeParameters{words(o, "parameterNames")}; }},
      {"subscribeConnectionGraph", [](const json&) -> Request { return SubscribeGraph{}; }},
      {"unsubscribeConnectionGraph", [](const json&) -> Request { return UnsubscribeGraph{}; }},
      {"fetchAsset", [](const json& o) -> Request {
         return FetchAsset{word(member(o, "uri"), "uri"),
                           number(member(o, "requestId"), "requestId")};
       }}};
  return kParsers;
}

// --- binary -------------------------------------------------------------------------------------

template <class Number>
void append(std::string& bytes, Number number) {
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    bytes += static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * i) & 0xff);
  }
}

// Reads a frame from its front.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}
  std::uint32_t u32() {
    const std::string_view four = take(4);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      value |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(four[i])) << (8 * i);
    }
    return value;
  }
  std::string_view take(std::size_t count) {
    if (bytes_.size() < count) throw ProtocolError("a binary frame ends before its fields do");
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

// --- JSON of the server -------------------------------------------------------------------------

template <class Range>
Json numbers_json(const Range& values) {
  Json array = Json::array();
  for (const auto value : values) array.add(value);
  return array;
}

Json schema_json(const MessageType& type) {
  return type.schema_encoding == "protobuf" ? Json(base64(type.schema)) : Json(type.schema);
}

Json type_json(const MessageType& type) {
  return Json::object()
      .set("encoding", type.encoding)
      .set("schemaName", type.schema_name)
      .set("schemaEncoding", type.schema_encoding)
      .set("schema", schema_json(type));
}

void set_value(Json& object, const Value& value) {
  struct Setter {
    Json& object;
    void operator()(std::monostate) const {}
    void operator()(bool v) const { object.set("value", v); }
    void operator()(std::int64_t v) const { object.set("value", v); }
    void operator()(double v) const { object.set("value", v).set("type", "float64"); }
    void operator()(const std::string& v) const { object.set("value", v); }
    void operator()(const std::vector<double>& v) const {
      object.set("value", numbers_json(v)).set("type", "float64_array");
    }
    void operator()(const std::vector<std::string>& v) const { object.set("value", Json(v)); }
  };
  std::visit(Setter{object}, value);
}

// Those of `now` that are not as in `before`.
Json changed_ends(const ConnectionGraph::Ends& before, const ConnectionGraph::Ends& now,
                  const char* ids) {
  Json array = Json::array();
  for (const auto& [name, nodes] : now) {
    const auto known = before.find(name);
    if (known != before.end() && known->second == nodes) continue;
    array.add(Json::object()
                  .set("name", name)
                  .set(ids, Json(std::vector<std::string>(nodes.begin(), nodes.end()))));
  }
  return array;
}

}  // namespace

std::string chosen_subprotocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = std::min(offered.find(','), offered.size());
    std::string_view one = offered.substr(0, comma);
    offered.remove_prefix(std::min(comma + 1, offered.size()));
    while (!one.empty() && (one.front() == ' ' || one.front() == '\t')) one.remove_prefix(1);
    while (!one.empty() && (one.back() == ' ' || one.back() == '\t')) one.remove_suffix(1);
    for (const char* ours : kSubprotocols) {
      if (one == ours) return ours;
    }
  }
  return "";
}

Request parse_request(std::string_view text) {
  const json object = json::parse(text, nullptr, false);
  if (object.is_discarded()) throw ProtocolError("a text frame is no JSON: " + in_quotes(text));
  if (!object.is_object())
    throw ProtocolError("a text frame is no JSON object: " + in_quotes(text));
  const std::string op = word(member(object, "op"), "op");
  std::vector<std::string> names;
  for (const auto& [name, parse] : parsers()) {
    if (name != op) {
      names.push_back(name);
      continue;
    }
    try {
      return parse(object);
    } catch (const ProtocolError& error) {
      throw ProtocolError(op + ": " + error.what());
    }
  }
  throw ProtocolError(
      fmt::format("op {} is unknown{}", in_quotes(op), text::nearest_match_hint(op, names)));
}

std::variant<ClientMessage, ServiceCall> parse_binary(std::string_view bytes) {
  if (bytes.empty()) throw ProtocolError("a binary frame is empty");
  Cursor cursor(bytes.substr(1));
  if (bytes.front() == kClientMessage) {
    const std::uint32_t channel = cursor.u32();
    return ClientMessage{channel, cursor.rest()};
  }
  if (bytes.front() == kServiceRequest) {
    ServiceCall call;
    call.service = cursor.u32();
    call.call = cursor.u32();
    const std::uint32_t size = cursor.u32();
    call.encoding = cursor.take(size);
    call.payload = cursor.rest();
    return call;
  }
  throw ProtocolError(fmt::format("opcode {} of a binary frame is unknown",
                                  static_cast<int>(static_cast<std::uint8_t>(bytes.front()))));
}

std::string server_info_text(const ServerInfo& info) {
  return Json::object()
      .set("op", "serverInfo")
      .set("name", info.name)
      .set("capabilities", Json(info.capabilities))
      .set("supportedEncodings", Json(info.encodings))
      .set("sessionId", info.session)
      .text();
}

std::string status_text(StatusLevel level, const std::string& message, const std::string& id) {
  Json object = Json::object()
                    .set("op", "status")
                    .set("level", static_cast<int>(level))
                    .set("message", message);
  if (!id.empty()) object.set("id", id);
  return object.text();
}

std::string advertise_text(const std::vector<std::pair<ChannelId, Channel>>& channels) {
  Json array = Json::array();
  for (const auto& [id, channel] : channels) {
    array.add(Json::object()
                  .set("id", id)
                  .set("topic", channel.topic)
                  .set("encoding", channel.type.encoding)
                  .set("schemaName", channel.type.schema_name)
                  .set("schema", schema_json(channel.type))
                  .set("schemaEncoding", channel.type.schema_encoding));
  }
  return Json::object().set("op", "advertise").set("channels", array).text();
}

std::string unadvertise_text(const std::vector<ChannelId>& ids) {
  return Json::object().set("op", "unadvertise").set("channelIds", numbers_json(ids)).text();
}

std::string advertise_services_text(
    const std::vector<std::pair<ServiceId, ServiceType>>& services) {
  Json array = Json::array();
  for (const auto& [id, service] : services) {
    array.add(Json::object()
                  .set("id", id)
                  .set("name", service.name)
                  .set("type", service.type)
                  .set("request", type_json(service.request))
                  .set("response", type_json(service.response))
                  // What clients of before 2024 read, as @foxglove/ws-protocol 0.7.
                  .set("requestSchema", schema_json(service.request))
                  .set("responseSchema", schema_json(service.response)));
  }
  return Json::object().set("op", "advertiseServices").set("services", array).text();
}

std::string unadvertise_services_text(const std::vector<ServiceId>& ids) {
  return Json::object()
      .set("op", "unadvertiseServices")
      .set("serviceIds", numbers_json(ids))
      .text();
}

std::string parameter_values_text(const std::vector<Parameter>& parameters,
                                  const std::optional<std::string>& id) {
  Json array = Json::array();
  for (const Parameter& one : parameters) {
    Json object = Json::object().set("name", one.name);
    set_value(object, one.value);
    array.add(object);
  }
  Json object = Json::object().set("op", "parameterValues").set("parameters", array);
  if (id) object.set("id", *id);
  return object.text();
}

std::string service_failure_text(ServiceId service, std::uint32_t call,
                                 const std::string& message) {
  return Json::object()
      .set("op", "serviceCallFailure")
      .set("serviceId", service)
      .set("callId", call)
      .set("message", message)
      .text();
}

std::string connection_graph_text(const ConnectionGraph& before, const ConnectionGraph& now) {
  std::vector<std::string> topics, services;
  const auto has = [](const ConnectionGraph::Ends& ends, const std::string& name) {
    return ends.count(name) > 0;
  };
  for (const auto* ends : {&before.published, &before.subscribed}) {
    for (const auto& [name, nodes] : *ends) {
      const bool twice = ends == &before.subscribed && has(before.published, name);
      if (!twice && !has(now.published, name) && !has(now.subscribed, name)) topics.push_back(name);
    }
  }
  for (const auto& [name, nodes] : before.services) {
    if (!has(now.services, name)) services.push_back(name);
  }
  return Json::object()
      .set("op", "connectionGraphUpdate")
      .set("publishedTopics", changed_ends(before.published, now.published, "publisherIds"))
      .set("subscribedTopics", changed_ends(before.subscribed, now.subscribed, "subscriberIds"))
      .set("advertisedServices", changed_ends(before.services, now.services, "providerIds"))
      .set("removedTopics", Json(topics))
      .set("removedServices", Json(services))
      .text();
}

std::string base64(std::string_view bytes) {
  static constexpr char kLetters[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < count ? static_cast<std::uint8_t>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kLetters[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

std::string from_base64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    int value = -1;
    if (c >= 'A' && c <= 'Z') value = c - 'A';
    if (c >= 'a' && c <= 'z') value = c - 'a' + 26;
    if (c >= '0' && c <= '9') value = c - '0' + 52;
    if (c == '+') value = 62;
    if (c == '/') value = 63;
    if (value < 0) throw ProtocolError("a schema or value is no base64");
    group = (group << 6 | static_cast<std::uint32_t>(value)) & 0xffffff;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 0xff);
  }
  return bytes;
}

std::array<std::uint8_t, 13> message_head(std::uint32_t subscription, std::uint64_t time) {
  std::string bytes(1, kMessageData);
  append(bytes, subscription);
  append(bytes, time);
  std::array<std::uint8_t, 13> head{};
  std::memcpy(head.data(), bytes.data(), head.size());
  return head;
}

std::string time_frame(std::uint64_t time) {
  std::string bytes(1, kTime);
  append(bytes, time);
  return bytes;
}

std::string service_response(ServiceId service, std::uint32_t call, const std::string& encoding,
                             std::string_view payload) {
  std::string bytes(1, kServiceResponse);
  append(bytes, service);
  append(bytes, call);
  append(bytes, static_cast<std::uint32_t>(encoding.size()));
  return bytes.append(encoding).append(payload);
}

std::string asset_response(std::uint32_t request, const std::string& error,
                           std::string_view content) {
  std::string bytes(1, kAssetResponse);
  append(bytes, request);
  bytes += static_cast<char>(error.empty() ? 0 : 1);
  append(bytes, static_cast<std::uint32_t>(error.size()));
  return bytes.append(error).append(error.empty() ? content : std::string_view());
}

}  // namespace prehend::viewing
