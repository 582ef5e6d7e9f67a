// A graph as viewers see it, over the wire.

#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "foxglove/RawImage.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "tests/nodes/viewer_graph.h"
#include "tests/viewing/websocket_client.h"

namespace prehend::nodes {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using prehend::testing::WebSocketClient;
using std::chrono::steady_clock;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// What a viewer was told, followed until something is there.
class Looking {
 public:
  explicit Looking(std::uint16_t port) : client_(port) {}

  bool until(const std::function<bool()>& condition, std::chrono::seconds patience = 10s) {
    const auto end = steady_clock::now() + patience;
    while (!condition()) {
      if (steady_clock::now() > end) return false;
      if (const auto frame = client_.receive(50ms)) take(*frame);
    }
    return true;
  }
  bool has(const std::string& topic) {
    return until([&] { return channels.count(topic) > 0; });
  }
  void say(const json& object) { client_.send_text(object.dump()); }
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
  std::map<std::string, json> parameters;
  json info, graph;
  std::optional<std::string> answer;
  int times = 0;

 private:
  void take(const WebSocketClient::Frame& frame) {
    if (!frame.is_text) return take_binary(frame.bytes);
    const json object = json::parse(frame.bytes);
    const std::string op = object["op"];
    if (op == "serverInfo") info = object;
    if (op == "connectionGraphUpdate") graph = object;
    if (op == "status") statuses.push_back(object["message"]);
    if (op == "serviceCallFailure") answer = object["message"];
    if (op == "parameterValues") {
      for (const json& one : object["parameters"]) parameters[one["name"]] = one["value"];
    }
    if (op == "advertise") {
      for (const json& one : object["channels"]) channels[one["topic"]] = one["id"];
    }
    if (op == "advertiseServices") {
      for (const json& one : object["services"]) services[one["name"]] = one["id"];
    }
    if (op == "unadvertise") {
      for (const json& id : object["channelIds"]) {
        std::erase_if(channels, [&](const auto& one) { return one.second == id; });
      }
    }
  }
  void take_binary(const std::string& bytes) {
    if (bytes[0] == 1) messages[bytes[1]].push_back(bytes.substr(13));
    if (bytes[0] == 2) ++times;
    if (bytes[0] == 3) answer = bytes.substr(13 + 4);
  }

  WebSocketClient client_;
};

class ViewerTest : public ViewerGraph {};

TEST_F(ViewerTest, ShowsTopicsRawAndAsWhatViewersDraw) {
  start_viewer();
  Looking looking(port());
  ASSERT_TRUE(looking.has("/models"));
  ASSERT_TRUE(looking.has("/viewer/objects"));
  looking.subscribe("/models", 1);
  looking.subscribe("/viewer/objects", 2);
  ASSERT_TRUE(looking.until([&] { return !looking.messages[1].empty(); })) << "it is latched";
  ASSERT_TRUE(looking.until([&] { return !looking.messages[2].empty(); }));
  msgs::ObjectModel model;
  ASSERT_TRUE(model.ParseFromString(looking.messages[1][0]));
  EXPECT_EQ(model.id(), 3u);
  ::foxglove::SceneUpdate update;
  ASSERT_TRUE(update.ParseFromString(looking.messages[2][0]));
  EXPECT_EQ(update.entities(0).id(), "object/3");
  EXPECT_TRUE(looking.until([&] { return looking.times > 2; }));
  // A second viewer, of whose topic there is a subscription already.
  Looking late(port());
  ASSERT_TRUE(late.has("/models"));
  late.subscribe("/models", 1);
  EXPECT_TRUE(late.until([&] { return !late.messages[1].empty(); }));
}

TEST_F(ViewerTest, ShowsWhatWasTurnedBeforeTheCameraAsItIsKnownThen) {
  held_.publish(model_of(3, 1, "held"));
  start_viewer();
  Looking looking(port());
  ASSERT_TRUE(looking.has("/viewer/objects"));
  looking.subscribe("/viewer/objects", 1);
  // Methods of the meshes that came, to be shown in this order.
  const auto shown = [&] {
    std::vector<std::string> methods;
    for (const std::string& bytes : looking.messages[1]) {
      ::foxglove::SceneUpdate update;
      EXPECT_TRUE(update.ParseFromString(bytes));
      for (const auto& entity : update.entities()) {
        for (const auto& pair : entity.metadata()) {
          if (pair.key() == "method") methods.push_back(entity.id() + " " + pair.value());
        }
      }
    }
    return methods;
  };
  const auto last = [&] {
    const auto methods = shown();
    return methods.empty() ? "" : methods.back();
  };
  ASSERT_TRUE(looking.until([&] { return last() == "object/3 held"; }));
  // The belief tells of the same look again, after that of another object.
  models_.publish(model_of(3, 1, "again"));
  models_.publish(model_of(2, 1, "other"));
  ASSERT_TRUE(looking.until([&] { return last() == "object/2 other"; }));
  EXPECT_THAT(shown(), Not(::testing::Contains("object/3 again")));
  models_.publish(model_of(3, 2, "new look"));
  ASSERT_TRUE(looking.until([&] { return last() == "object/3 new look"; }));
  held_.publish(model_of(3, 1, "late"));
  models_.publish(model_of(2, 2, "end"));
  ASSERT_TRUE(looking.until([&] { return last() == "object/2 end"; }));
  EXPECT_THAT(shown(), Not(::testing::Contains("object/3 late")));
}

TEST_F(ViewerTest, SubscribesOnlyToWhatSomebodyLooksAt) {
  start_viewer();
  Looking looking(port());
  ASSERT_TRUE(looking.has("/clock_like"));
  EXPECT_EQ(counts_.subscriber_count(), 0u);
  looking.subscribe("/clock_like", 1);
  ASSERT_TRUE(looking.until([&] { return looking.messages[1].size() > 3; }));
  EXPECT_EQ(counts_.subscriber_count(), 1u);
  {
    Looking other(port());
    ASSERT_TRUE(other.has("/clock_like"));
    other.subscribe("/clock_like", 1);
    ASSERT_TRUE(other.until([&] { return !other.messages[1].empty(); }));
    EXPECT_EQ(counts_.subscriber_count(), 1u) << "viewers share a subscription";
  }
  looking.say({{"op", "unsubscribe"}, {"subscriptionIds", {1}}});
  EXPECT_TRUE(looking.until([&] { return counts_.subscriber_count() == 0; }));
}

TEST_F(ViewerTest, AViewerThatWentAwayLeavesNothingSubscribed) {
  start_viewer();
  {
    Looking looking(port());
    ASSERT_TRUE(looking.has("/clock_like"));
    looking.subscribe("/clock_like", 1);
    ASSERT_TRUE(looking.until([&] { return counts_.subscriber_count() == 1; }));
  }
  Looking other(port());
  EXPECT_TRUE(other.until([&] { return counts_.subscriber_count() == 0; }));
}

TEST_F(ViewerTest, PadsAreImages) {
  start_viewer();
  Looking looking(port());
  ASSERT_TRUE(looking.has("/viewer/pad/left"));
  looking.subscribe("/viewer/pad/left", 1);
  msgs::TactileFrame frame;
  frame.set_rows(2);
  frame.set_columns(1);
  frame.set_newton_per_count(0.25);
  frame.add_intensity(1);
  frame.add_intensity(2);
  ASSERT_TRUE(looking.until([&] {
    frames_.publish(frame);
    return !looking.messages[1].empty();
  }));
  ::foxglove::RawImage image;
  ASSERT_TRUE(image.ParseFromString(looking.messages[1][0]));
  float newtons[2];
  ASSERT_EQ(image.data().size(), sizeof newtons);
  std::memcpy(newtons, image.data().data(), sizeof newtons);
  EXPECT_THAT(newtons, ElementsAre(0.25f, 0.5f));
}

TEST_F(ViewerTest, ADamagedMessageIsLeftOutAndTheNextOneIsShown) {
  start_viewer();
  Looking looking(port());
  ASSERT_TRUE(looking.has("/viewer/pad/left"));
  looking.subscribe("/viewer/pad/left", 1);
  msgs::TactileFrame bad, good;
  bad.set_rows(1000000);
  bad.set_columns(1000000);
  good.set_rows(1);
  good.set_columns(1);
  good.add_intensity(1);
  ASSERT_TRUE(looking.until([&] {
    frames_.publish(bad);
    frames_.publish(good);
    return looking.messages[1].size() > 3;
  }));
}

TEST_F(ViewerTest, ParametersAreGotSetFollowedAndDescribed) {
  start_viewer();
  Looking looking(port());
  looking.say({{"op", "getParameters"}, {"parameterNames", {"talker.gain"}}});
  ASSERT_TRUE(looking.until([&] { return looking.parameters.count("talker.gain") > 0; }));
  EXPECT_EQ(looking.parameters["talker.gain"], 1);
  looking.say(
      {{"op", "setParameters"}, {"parameters", {{{"name", "talker.gain"}, {"value", 7.5}}}}});
  ASSERT_TRUE(looking.until([&] { return looking.parameters["talker.gain"] == 7.5; }));
  EXPECT_EQ(talker_.parameter<double>("gain"), 7.5);
  looking.say(
      {{"op", "setParameters"}, {"parameters", {{{"name", "talker.gain"}, {"value", 750}}}}});
  ASSERT_TRUE(looking.until([&] { return !looking.statuses.empty(); }));
  EXPECT_THAT(looking.statuses[0], HasSubstr("gain"));
  EXPECT_EQ(talker_.parameter<double>("gain"), 7.5);
  looking.say({{"op", "subscribeParameterUpdates"}, {"parameterNames", json::array()}});
  ASSERT_TRUE(looking.until([&] {
    talker_.set_parameter("gain", "9");
    return looking.parameters["talker.gain"] == 9;
  }));
  const json described = json::parse(looking.call("/viewer/describe_parameters", "{}"));
  bool found = false;
  for (const json& one : described) {
    if (one["name"] != "talker.gain") continue;
    found = true;
    EXPECT_EQ(one["max"], 100);
    EXPECT_EQ(one["type"], "double");
  }
  EXPECT_TRUE(found);
}

TEST_F(ViewerTest, ServicesAreCalledInJsonToo) {
  start_viewer();
  Looking looking(port());
  EXPECT_THAT(looking.call("/talk", R"({"name": "well"})"), HasSubstr("talked to well"));
  EXPECT_THAT(looking.call("/talk", R"({"name": "badly"})"), HasSubstr("not badly"));
  EXPECT_THAT(looking.call("/talk", R"({"nam": "x"})"), HasSubstr("NamedThing"));
  EXPECT_EQ(looking.services.count("/viewer/stop"), 0u) << "nobody serves /emergency_stop/stop";
}

TEST_F(ViewerTest, StopsTheRobotWhereThatCanBe) {
  std::string reason;
  const auto stop = talker_.serve<msgs::EmergencyStopRequest, msgs::Acknowledge>(
      "/emergency_stop/stop", [&](const msgs::EmergencyStopRequest& request) {
        reason = request.source() + ": " + request.reason();
        msgs::Acknowledge answer;
        answer.set_success(true);
        return answer;
      });
  start_viewer();
  Looking looking(port());
  EXPECT_EQ(looking.call("/viewer/stop", R"({"reason": "a click"})"),
            R"({"ok":true,"message":""})");
  EXPECT_EQ(reason, "viewer: a click");
}

TEST_F(ViewerTest, ThoseWhoMayOnlyLookCannotDoAnything) {
  const auto stop = talker_.serve<msgs::EmergencyStopRequest, msgs::Acknowledge>(
      "/emergency_stop/stop", [](const auto&) { return msgs::Acknowledge(); });
  start_viewer(false);
  Looking looking(port());
  looking.say(
      {{"op", "setParameters"}, {"parameters", {{{"name", "talker.gain"}, {"value", 7.5}}}}});
  looking.say({{"op", "advertise"}, {"channels", json::array()}});
  ASSERT_TRUE(looking.until([&] { return looking.statuses.size() == 2; }));
  EXPECT_EQ(talker_.parameter<double>("gain"), 1);
  ASSERT_TRUE(looking.until([&] { return looking.services.count("/viewer/describe_parameters"); }));
  EXPECT_EQ(looking.services.size(), 1u);
}

TEST_F(ViewerTest, TopicsComeAndGo) {
  start_viewer();
  Looking looking(port());
  ASSERT_TRUE(looking.has("/models"));
  {
    const auto late = talker_.advertise<msgs::Clock>("/late", graph::QoS::queue(1));
    EXPECT_TRUE(looking.has("/late"));
  }
  EXPECT_TRUE(looking.until([&] { return looking.channels.count("/late") == 0; }));
  looking.say({{"op", "subscribeConnectionGraph"}});
  EXPECT_TRUE(looking.until([&] { return looking.graph.is_object(); }));
  EXPECT_THAT(looking.graph.dump(), HasSubstr(R"({"name":"/models","publisherIds":["talker"]})"));
}

}  // namespace
}  // namespace prehend::nodes
