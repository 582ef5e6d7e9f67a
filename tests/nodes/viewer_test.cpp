// A graph as viewers see it, over the wire.

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "foxglove/RawImage.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "tests/nodes/looking.h"
#include "tests/nodes/viewer_graph.h"

namespace prehend::nodes {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using std::chrono::steady_clock;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

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
