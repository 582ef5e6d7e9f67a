// The bytes and words of the public protocol, from its worked example.

#include "prehend/viewing/protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace prehend::viewing {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string bytes(std::initializer_list<int> values) {
  std::string text;
  for (const int value : values) text += static_cast<char>(value);
  return text;
}

std::string error_of(const std::string& text) {
  try {
    parse_request(text);
  } catch (const ProtocolError& error) {
    return error.what();
  }
  return "";
}

TEST(Protocol, TheViewersFirstSubprotocolOfOursIsTaken) {
  EXPECT_EQ(chosen_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(chosen_subprotocol("x, foxglove.sdk.v1,foxglove.websocket.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(chosen_subprotocol(" foxglove.websocket.v1 , foxglove.sdk.v1"),
            "foxglove.websocket.v1");
  EXPECT_EQ(chosen_subprotocol(""), "");
  EXPECT_EQ(chosen_subprotocol("foxglove.websocket.v2, ,,"), "");
}

TEST(Protocol, BinaryFramesAreThoseOfTheExample) {
  const auto head = message_head(0, 1'000'000'000);
  EXPECT_EQ(std::string(head.begin(), head.end()),
            bytes({1, 0, 0, 0, 0, 0x00, 0xca, 0x9a, 0x3b, 0, 0, 0, 0}));
  EXPECT_EQ(time_frame(1'000'000'000), bytes({2, 0x00, 0xca, 0x9a, 0x3b, 0, 0, 0, 0}));
  EXPECT_EQ(asset_response(5, "", "<robot/>"), bytes({4, 5, 0, 0, 0, 0, 0, 0, 0, 0}) + "<robot/>");
  EXPECT_EQ(asset_response(5, "no", "x"), bytes({4, 5, 0, 0, 0, 1, 2, 0, 0, 0}) + "no");
  EXPECT_EQ(service_response(1, 9, "json", R"({"ok":true})"),
            bytes({3, 1, 0, 0, 0, 9, 0, 0, 0, 4, 0, 0, 0}) + R"(json{"ok":true})");
  const std::string request = bytes({2, 1, 0, 0, 0, 9, 0, 0, 0, 4, 0, 0, 0}) + "json{}";
  const auto call = std::get<ServiceCall>(parse_binary(request));
  EXPECT_EQ(call.service, 1u);
  EXPECT_EQ(call.call, 9u);
  EXPECT_EQ(call.encoding, "json");
  EXPECT_EQ(call.payload, "{}");
  const std::string message = bytes({1, 1, 0, 0, 0}) + "{}";
  EXPECT_EQ(std::get<ClientMessage>(parse_binary(message)).payload, "{}");
}

TEST(Protocol, DamagedBinaryFramesAreRefusedInWords) {
  EXPECT_THROW(parse_binary(""), ProtocolError);
  EXPECT_THROW(parse_binary(bytes({1, 0, 0})), ProtocolError);
  EXPECT_THROW(parse_binary(bytes({9, 0, 0, 0, 0})), ProtocolError);
  EXPECT_THROW(parse_binary(bytes({2, 1, 0, 0, 0, 9, 0, 0, 0, 255, 255, 255, 255}) + "json"),
               ProtocolError);
}

TEST(Protocol, RequestsAreRead) {
  const auto subscribe = std::get<Subscribe>(
      parse_request(R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":1}]})"));
  ASSERT_EQ(subscribe.subscriptions.size(), 1u);
  EXPECT_EQ(subscribe.subscriptions[0].id, 7u);
  EXPECT_EQ(subscribe.subscriptions[0].channel, 1u);
  const auto set = std::get<SetParameters>(parse_request(
      R"({"op":"setParameters","parameters":[{"name":"a.b","value":30,"type":"float64"},)"
      R"({"name":"a.c","value":3},{"name":"a.d","value":["x"]},{"name":"a.e","value":[1,2.5]},)"
      R"({"name":"a.f"}],"id":"q"})"));
  EXPECT_EQ(set.id, "q");
  EXPECT_EQ(std::get<double>(set.parameters[0].value), 30);
  EXPECT_EQ(std::get<std::int64_t>(set.parameters[1].value), 3);
  EXPECT_THAT(std::get<std::vector<std::string>>(set.parameters[2].value), ElementsAre("x"));
  EXPECT_THAT(std::get<std::vector<double>>(set.parameters[3].value), ElementsAre(1, 2.5));
  EXPECT_TRUE(std::holds_alternative<std::monostate>(set.parameters[4].value));
}

TEST(Protocol, GarbageIsAnsweredInWords) {
  EXPECT_THAT(error_of("{"), HasSubstr("no JSON"));
  EXPECT_THAT(error_of("[]"), HasSubstr("no JSON object"));
  EXPECT_THAT(error_of("{}"), HasSubstr("'op' is missing"));
  EXPECT_THAT(error_of(R"({"op":3})"), HasSubstr("'op' is to be a text"));
  EXPECT_THAT(error_of(R"({"op":"subscrib","subscriptions":[]})"), HasSubstr("subscribe"));
  EXPECT_THAT(error_of(R"({"op":"subscribe"})"), HasSubstr("'subscriptions' is missing"));
  EXPECT_THAT(error_of(R"({"op":"subscribe","subscriptions":[3]})"), HasSubstr("JSON object"));
  EXPECT_THAT(error_of(R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})"),
              HasSubstr("number from 0"));
  EXPECT_THAT(error_of(R"({"op":"fetchAsset","uri":"x","requestId":1e30})"), HasSubstr("number"));
  EXPECT_THAT(error_of(R"({"op":"setParameters","parameters":[{"name":"a","value":{}}]})"),
              HasSubstr("'a'"));
  EXPECT_THAT(error_of(std::string(100000, '[')), HasSubstr("no JSON"));
}

TEST(Protocol, Base64IsThatOfTheStandard) {
  const std::pair<const char*, const char*> known[] = {{"", ""},
                                                       {"f", "Zg=="},
                                                       {"fo", "Zm8="},
                                                       {"foo", "Zm9v"},
                                                       {"foob", "Zm9vYg=="},
                                                       {"fooba", "Zm9vYmE="},
                                                       {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : known) {
    EXPECT_EQ(base64(plain), coded);
    EXPECT_EQ(from_base64(coded), plain);
  }
  EXPECT_EQ(from_base64(base64(bytes({0, 255, 128, 7}))), bytes({0, 255, 128, 7}));
  EXPECT_THROW(from_base64("a b"), ProtocolError);
}

TEST(Protocol, TheConnectionGraphTellsWhatChanged) {
  ConnectionGraph before, now;
  before.published = {{"/a", {"x"}}, {"/b", {"x"}}, {"/c", {"x"}}};
  before.services = {{"/s", {"x"}}};
  now.published = {{"/a", {"x"}}, {"/b", {"x", "y"}}};
  now.subscribed = {{"/a", {"z"}}};
  const json update = json::parse(connection_graph_text(before, now));
  EXPECT_EQ(update["publishedTopics"], json::parse(R"([{"name":"/b","publisherIds":["x","y"]}])"));
  EXPECT_EQ(update["subscribedTopics"], json::parse(R"([{"name":"/a","subscriberIds":["z"]}])"));
  EXPECT_EQ(update["advertisedServices"], json::array());
  EXPECT_EQ(update["removedTopics"], json::parse(R"(["/c"])"));
  EXPECT_EQ(update["removedServices"], json::parse(R"(["/s"])"));
}

TEST(Protocol, WholeRealsStayReals) {
  const json answer =
      json::parse(parameter_values_text({{"a.b", 30.0}, {"a.c", std::string("x")}}, "q"));
  EXPECT_EQ(answer["id"], "q");
  EXPECT_EQ(answer["parameters"][0]["type"], "float64");
  EXPECT_EQ(answer["parameters"][0]["value"], 30);
  EXPECT_FALSE(answer["parameters"][1].contains("type"));
}

}  // namespace
}  // namespace prehend::viewing
