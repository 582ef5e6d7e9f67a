// What viewers get for what they say, without sockets.

#include "prehend/viewing/hub.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace prehend::viewing {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Payload payload(const std::string& text) { return std::make_shared<const std::string>(text); }

class HubTest : public ::testing::Test {
 protected:
  HubTest() {
    Handlers handlers;
    handlers.on_channel_wanted = [this](ChannelId id, bool wanted) {
      wanted_.emplace_back(id, wanted);
    };
    handlers.on_get_parameters = [](const auto&, auto answer) { answer({{{"a.b", 1.0}}, ""}); };
    handlers.on_set_parameters = [](const auto& parameters, auto answer) {
      answer({parameters, "a.c: is read-only"});
    };
    handlers.on_service_call = [](ServiceId, const ServiceCall& call, auto answer) {
      if (call.payload == "throw") throw std::runtime_error("it threw");
      answer({call.payload == "fail" ? "it failed" : "", "json", std::string(call.payload)});
    };
    handlers.on_client_advertise = [this](ViewerId, const ClientChannel& channel) {
      if (channel.topic == "/no") throw std::runtime_error("not this");
      published_.push_back("+" + channel.topic);
    };
    handlers.on_client_unadvertise = [this](ViewerId, std::uint32_t id) {
      published_.push_back("-" + std::to_string(id));
    };
    handlers.on_client_message = [this](ViewerId, std::uint32_t, std::string_view text) {
      published_.emplace_back(text);
    };
    handlers.on_fetch_asset = [](const std::string& uri, auto answer) {
      answer({uri == "x" ? "" : "no such thing", "content"});
    };
    hub_.emplace("test", "1", handlers, ViewerLimits{10000, 10000, 2, 10},
                 [](const std::function<void()>& function) { function(); });
    hub_->add_channel(1, {"/stream", {"json", "S", "jsonschema", "{}"}, 0, false});
    hub_->add_channel(2, {"/latched", {"protobuf", "L", "protobuf", "abc"}, 2, false});
    hub_->add_service(1, {"/s", "s", {"json", "", "", ""}, {"json", "", "", ""}});
  }

  ViewerId connect() {
    return hub_->connect("peer", {[] {}, [this](const std::string& why) { closed_ = why; }});
  }
  // What waits for a viewer: JSON, or {"bytes": payload, "subscription": id}.
  std::vector<json> received(ViewerId id) {
    std::vector<json> frames;
    while (const auto frame = hub_->next_frame(id)) {
      if (frame->is_text) {
        frames.push_back(json::parse(*frame->payload));
      } else if (frame->head_size > 0) {
        frames.push_back({{"bytes", *frame->payload}, {"subscription", frame->subscription}});
      } else {
        frames.push_back({{"opcode", static_cast<int>(frame->payload->at(0))},
                          {"content", frame->payload->substr(1)}});
      }
    }
    return frames;
  }
  std::vector<std::string> words(ViewerId id) {
    std::vector<std::string> texts;
    for (const json& frame : received(id)) {
      if (frame.value("op", "") == "status") texts.push_back(frame["message"]);
    }
    return texts;
  }
  void say(ViewerId id, const std::string& text) { hub_->receive_text(id, text); }
  void subscribe(ViewerId id, int subscription, int channel) {
    say(id, json{{"op", "subscribe"},
                 {"subscriptions", {{{"id", subscription}, {"channelId", channel}}}}}
                .dump());
  }

  std::vector<std::pair<ChannelId, bool>> wanted_;
  std::vector<std::string> published_;
  std::string closed_;
  std::optional<Hub> hub_;
};

TEST_F(HubTest, GreetsWithServerChannelsAndServices) {
  const auto frames = received(connect());
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0]["op"], "serverInfo");
  EXPECT_THAT(frames[0]["capabilities"].get<std::vector<std::string>>(), Contains("services"));
  EXPECT_EQ(frames[1]["channels"][0]["schema"], "{}");
  EXPECT_EQ(frames[1]["channels"][1]["schema"], "YWJj") << "base64";
  EXPECT_EQ(frames[2]["services"][0]["name"], "/s");
}

TEST_F(HubTest, MessagesCarryTheSubscriptionOfEachViewer) {
  const ViewerId a = connect(), b = connect();
  subscribe(a, 7, 1);
  subscribe(b, 9, 1);
  EXPECT_THAT(wanted_, ElementsAre(std::pair<ChannelId, bool>(1, true))) << "once";
  received(a);
  received(b);
  hub_->publish(1, 5, payload("x"), "");
  EXPECT_EQ(received(a).at(0)["subscription"], 7);
  EXPECT_EQ(received(b).at(0)["subscription"], 9);
  say(a, R"({"op":"unsubscribe","subscriptionIds":[7]})");
  EXPECT_EQ(wanted_.size(), 1u);
  hub_->publish(1, 6, payload("y"), "");
  EXPECT_THAT(received(a), IsEmpty());
  hub_->disconnect(b);
  EXPECT_EQ(wanted_.back(), (std::pair<ChannelId, bool>(1, false)));
}

TEST_F(HubTest, WhoComesLaterGetsTheLastOfEachSender) {
  const ViewerId a = connect();
  subscribe(a, 1, 2);
  for (const char* text : {"1", "2", "3"}) hub_->publish(2, 0, payload(text), "x");
  hub_->publish(2, 0, payload("y"), "y");
  const ViewerId b = connect();
  received(b);
  subscribe(b, 1, 2);
  std::string got;
  for (const json& frame : received(b)) got += frame["bytes"].get<std::string>();
  EXPECT_EQ(got, "23y");
}

TEST_F(HubTest, ASlowViewerIsToldOnceWhatItMissed) {
  const ViewerId slow = connect(), quick = connect();
  subscribe(slow, 1, 1);
  subscribe(quick, 1, 1);
  received(slow);
  received(quick);
  for (int i = 0; i < 100; ++i) {
    hub_->publish(1, 0, payload(std::string(1000, 'x')), "");
    EXPECT_EQ(received(quick).size(), 1u);
  }
  hub_->tell_losses();
  hub_->tell_losses();
  int told = 0;
  for (const json& frame : received(slow)) {
    if (frame.value("id", "") != "dropped") continue;
    ++told;
    EXPECT_EQ(frame["level"], 1);
  }
  EXPECT_EQ(told, 1);
  hub_->tell_losses();
  EXPECT_THAT(words(quick), IsEmpty());
}

TEST_F(HubTest, WhoAsksWithoutReadingIsGivenUp) {
  const ViewerId id = connect();
  for (int i = 0; i < 1000; ++i) say(id, "garbage");
  EXPECT_THAT(closed_, HasSubstr("do not read"));
}

TEST_F(HubTest, WhatCannotBeIsRefusedInWords) {
  const ViewerId id = connect();
  received(id);
  subscribe(id, 1, 77);
  EXPECT_THAT(words(id), ElementsAre(HasSubstr("no channel 77")));
  subscribe(id, 1, 1);
  subscribe(id, 2, 1);
  subscribe(id, 1, 2);
  EXPECT_EQ(words(id).size(), 2u);
  say(id, R"({"op":"unadvertise","channelIds":[3]})");
  EXPECT_THAT(words(id), ElementsAre(HasSubstr("no channel 3")));
  hub_->receive_binary(id, std::string("\x01\x05\0\0\0x", 6));
  EXPECT_THAT(words(id), ElementsAre(HasSubstr("advertise it first")));
  hub_->receive_binary(id, std::string("\xff", 1));
  EXPECT_THAT(words(id), ElementsAre(HasSubstr("255")));
}

TEST_F(HubTest, ViewersPublish) {
  const ViewerId id = connect();
  received(id);
  const auto advertise = [&](int channel, const char* topic) {
    say(id, json{{"op", "advertise"},
                 {"channels",
                  {{{"id", channel}, {"topic", topic}, {"encoding", "json"}, {"schemaName", "s"}}}}}
                .dump());
  };
  advertise(1, "/no");
  EXPECT_THAT(words(id), ElementsAre(HasSubstr("not this")));
  advertise(1, "/yes");
  advertise(2, "/too");
  advertise(3, "/many");
  EXPECT_THAT(words(id), ElementsAre(HasSubstr("2 channels at most")));
  hub_->receive_binary(id, std::string("\x01\x01\0\0\0{}", 7));
  hub_->disconnect(id);
  EXPECT_THAT(published_, ElementsAre("+/yes", "+/too", "{}", "-1", "-2"));
}

TEST_F(HubTest, ParametersAreAskedSetAndFollowed) {
  const ViewerId id = connect();
  received(id);
  say(id, R"({"op":"getParameters","parameterNames":[],"id":"q"})");
  auto frames = received(id);
  EXPECT_EQ(frames.at(0)["id"], "q");
  EXPECT_EQ(frames[0]["parameters"][0]["name"], "a.b");
  say(id, R"({"op":"setParameters","parameters":[{"name":"a.c","value":1}]})");
  frames = received(id);
  EXPECT_THAT(frames.at(0)["message"].get<std::string>(), HasSubstr("read-only"));
  EXPECT_EQ(frames.at(1)["op"], "parameterValues");
  hub_->publish_parameters({{"a.b", 2.0}});
  EXPECT_THAT(received(id), IsEmpty());
  say(id, R"({"op":"subscribeParameterUpdates","parameterNames":["a.b"]})");
  hub_->publish_parameters({{"a.b", 2.0}, {"a.c", 3.0}});
  EXPECT_EQ(received(id).at(0)["parameters"].size(), 1u);
  say(id, R"({"op":"unsubscribeParameterUpdates","parameterNames":["a.b"]})");
  hub_->publish_parameters({{"a.b", 2.0}});
  EXPECT_THAT(received(id), IsEmpty());
}

TEST_F(HubTest, ServicesAnswerOrFailInWords) {
  const ViewerId id = connect();
  received(id);
  const auto call = [&](int service, const std::string& text) {
    std::string bytes("\x02", 1);
    for (const int number : {service, 4, 4}) {
      bytes += static_cast<char>(number) + std::string(3, '\0');
    }
    hub_->receive_binary(id, bytes + "json" + text);
    return received(id).at(0);
  };
  EXPECT_EQ(call(1, "hello")["opcode"], 3);
  EXPECT_EQ(call(1, "fail")["message"], "it failed");
  EXPECT_EQ(call(1, "throw")["message"], "it threw");
  const json unknown = call(9, "hello");
  EXPECT_EQ(unknown["op"], "serviceCallFailure");
  EXPECT_EQ(unknown["callId"], 4);
}

TEST_F(HubTest, AssetsAreFetched) {
  const ViewerId id = connect();
  received(id);
  say(id, R"({"op":"fetchAsset","uri":"x","requestId":5})");
  EXPECT_EQ(received(id).at(0)["opcode"], 4);
  say(id, R"({"op":"fetchAsset","uri":"y","requestId":5})");
  EXPECT_THAT(received(id).at(0)["content"].get<std::string>(), HasSubstr("no such thing"));
}

TEST_F(HubTest, AChannelThatGoesTakesItsSubscriptions) {
  const ViewerId id = connect();
  subscribe(id, 1, 1);
  received(id);
  hub_->remove_channel(1);
  EXPECT_EQ(received(id).at(0)["op"], "unadvertise");
  say(id, R"({"op":"unsubscribe","subscriptionIds":[1]})");
  EXPECT_THAT(words(id), IsEmpty()) << "the viewer may not have known it yet";
  hub_->publish(1, 0, payload("x"), "");
  EXPECT_THAT(received(id), IsEmpty());
}

TEST_F(HubTest, TheConnectionGraphComesAtOnceAndWhenItChanges) {
  const ViewerId id = connect();
  received(id);
  ConnectionGraph graph;
  graph.published["/a"] = {"x"};
  hub_->set_graph(graph);
  EXPECT_THAT(received(id), IsEmpty());
  say(id, R"({"op":"subscribeConnectionGraph"})");
  EXPECT_EQ(received(id).at(0)["publishedTopics"][0]["name"], "/a");
  hub_->set_graph(graph);
  EXPECT_THAT(received(id), IsEmpty());
  hub_->set_graph({});
  EXPECT_EQ(received(id).at(0)["removedTopics"][0], "/a");
}

}  // namespace
}  // namespace prehend::viewing
