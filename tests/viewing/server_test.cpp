// The server over sockets on loopback: handshake, pages, hostile peers, viewers that do not read.

#include "prehend/viewing/server.h"

#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "prehend/viewing/page_files.h"
#include "tests/viewing/websocket_client.h"

namespace prehend::viewing {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using prehend::testing::http;
using prehend::testing::http_get;
using prehend::testing::WebSocketClient;
using ::testing::HasSubstr;

bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

class ServerTest : public ::testing::Test {
 protected:
  ServerOptions options() const {
    ServerOptions options;
    options.port = 0;
    options.page = "docs";  // any folder there is
    options.most_frame_bytes = 100000;
    return options;
  }
  Handlers handlers() {
    Handlers handlers;
    handlers.on_channel_wanted = [this](ChannelId, bool wanted) { wanted_ += wanted ? 1 : -1; };
    return handlers;
  }
  // The next text frame of that op; null when none comes.
  static json next(WebSocketClient& client, const std::string& op) {
    for (int i = 0; i < 10000; ++i) {
      const auto frame = client.receive();
      if (!frame) return nullptr;
      if (!frame->is_text) continue;
      json object = json::parse(frame->bytes);
      if (object["op"] == op) return object;
    }
    return nullptr;
  }
  static std::string refusal(std::uint16_t port, const WebSocketClient::Options& options) {
    try {
      WebSocketClient client(port, options);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  static void subscribe(WebSocketClient& client, ChannelId channel) {
    client.send_text(
        json{{"op", "subscribe"}, {"subscriptions", {{{"id", 0}, {"channelId", channel}}}}}.dump());
  }

  std::atomic<int> wanted_{0};
};

TEST_F(ServerTest, SpeaksBothSubprotocolsAndRefusesOthersInWords) {
  const Server server(options(), {});
  for (const char* name : {"foxglove.websocket.v1", "foxglove.sdk.v1"}) {
    WebSocketClient client(server.port(), {std::string("other, ") + name, "/", {}, 0});
    EXPECT_EQ(client.subprotocol(), name);
    EXPECT_EQ(next(client, "serverInfo")["name"], "prehend");
  }
  EXPECT_THAT(refusal(server.port(), {"other.v1", "/", {}, 0}), HasSubstr("400"));
  EXPECT_THAT(refusal(server.port(), {"", "/", {}, 0}), HasSubstr("400"));
  const auto answer = http(server.port(),
                           "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
                           "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
  EXPECT_EQ(answer.status, 400);
  EXPECT_THAT(answer.body, HasSubstr("foxglove.sdk.v1"));
}

TEST_F(ServerTest, RefusesPagesOfOthersAndWhoHasNoToken) {
  auto with_token = options();
  with_token.token = "abc";
  const Server server(with_token, {});
  EXPECT_THAT(server.page_address(), HasSubstr("/?token=abc"));
  const std::string websocket = "foxglove.sdk.v1";
  EXPECT_THAT(refusal(server.port(), {websocket, "/", {}, 0}), HasSubstr("403"));
  EXPECT_THAT(refusal(server.port(), {websocket, "/?token=abc", {}, 0}), "");
  EXPECT_THAT(
      refusal(server.port(), {websocket, "/?token=abc", {{"Origin", "https://evil.example"}}, 0}),
      HasSubstr("403"));
}

TEST_F(ServerTest, IsForThisMachineUnlessThereIsAToken) {
  auto open = options();
  open.address = "0.0.0.0";
  EXPECT_THROW(Server(open, {}), std::runtime_error);
  auto wrong = options();
  wrong.address = "nowhere";
  EXPECT_THROW(Server(wrong, {}), std::runtime_error);
}

TEST_F(ServerTest, NamesAPortThatIsTaken) {
  const Server first(options(), {});
  auto second = options();
  second.port = first.port();
  try {
    const Server server(second, {});
    FAIL() << "two servers at one port";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(std::to_string(first.port())));
    EXPECT_THAT(error.what(), HasSubstr("another"));
  }
}

TEST_F(ServerTest, ServesFilesWithHeadersThatKeepOthersOut) {
  const Server server(options(), {});
  const auto answer = http_get(server.port(), "/README.md");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.body, HasSubstr("# Index"));
  EXPECT_EQ(answer.headers.at("content-security-policy"), kContentSecurityPolicy);
  EXPECT_EQ(answer.headers.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(http_get(server.port(), "/../README.md").status, 404);
  EXPECT_EQ(http(server.port(), "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\n\r\n").status,
            405);
  EXPECT_EQ(http(server.port(), "garbage\r\n\r\n").status, 400);
}

TEST_F(ServerTest, GarbageIsAnsweredAndTheConnectionGoesOn) {
  const Server server(options(), {});
  WebSocketClient client(server.port());
  client.send_text("{");
  EXPECT_THAT(next(client, "status")["message"].get<std::string>(), HasSubstr("no JSON"));
  client.send_binary("\xff");
  EXPECT_THAT(next(client, "status")["message"].get<std::string>(), HasSubstr("255"));
  client.send_text(R"({"op":"getParameters","parameterNames":[]})");
  EXPECT_THAT(next(client, "status")["message"].get<std::string>(), HasSubstr("not offered"));
  client.send_text(R"({"op":"subscribeConnectionGraph"})");
  EXPECT_TRUE(next(client, "connectionGraphUpdate").is_object());
}

TEST_F(ServerTest, AnOversizedFrameEndsTheConnectionInWords) {
  const Server server(options(), {});
  WebSocketClient client(server.port()), other(server.port());
  try {
    client.send_text(std::string(300000, ' '));
  } catch (const std::runtime_error&) {
    // It may be closed before all of it was sent.
  }
  while (client.receive()) {
  }
  EXPECT_EQ(client.close_code(), 1009);
  EXPECT_THAT(client.close_reason(), HasSubstr("100000 bytes"));
  other.send_text("{");
  EXPECT_TRUE(next(other, "status").is_object()) << "others go on";
}

TEST_F(ServerTest, LateViewersGetWhatIsLatched) {
  Server server(options(), handlers());
  const ChannelId id = server.add_channel({"/l", {"json", "L", "jsonschema", "{}"}, 1, false});
  WebSocketClient first(server.port());
  subscribe(first, id);
  ASSERT_TRUE(eventually([&] { return wanted_ == 1; }));
  server.publish(id, 7, std::make_shared<const std::string>("kept"));
  WebSocketClient late(server.port());
  subscribe(late, id);
  std::string got;
  while (const auto frame = late.receive()) {
    if (frame->is_text) continue;
    got = frame->bytes;
    break;
  }
  EXPECT_EQ(got, std::string("\x01\0\0\0\0\x07\0\0\0\0\0\0\0kept", 17));
  first.close();
  late.close();
  EXPECT_TRUE(eventually([&] { return wanted_ == 0; }));
}

TEST_F(ServerTest, AViewerThatDoesNotReadHoldsNobodyUp) {
  auto small = options();
  small.limits.outbox_bytes = 1 << 20;
  Server server(small, handlers());
  const ChannelId id = server.add_channel({"/s", {"json", "S", "jsonschema", "{}"}, 0, false});
  WebSocketClient stuck(server.port(), {"foxglove.sdk.v1", "/", {}, 4096});
  WebSocketClient quick(server.port());
  subscribe(stuck, id);
  subscribe(quick, id);
  ASSERT_TRUE(eventually([&] { return wanted_ == 1; }));
  ASSERT_TRUE(next(quick, "advertise").is_object());
  const auto payload = std::make_shared<const std::string>(100000, 'x');
  constexpr int kMessages = 200;
  int got = 0;
  for (int i = 0; i < kMessages; ++i) {
    server.publish(id, 0, payload);
    const auto frame = quick.receive();
    if (frame && frame->bytes.size() == payload->size() + 13) ++got;
  }
  // A machine that is busy makes even a reader miss some.
  EXPECT_GE(got, kMessages * 9 / 10) << "one viewer is not held up by another";
  // What is sent, what waits, and what the test has: 20 MB were published.
  EXPECT_LT(payload.use_count(), 20);
  EXPECT_EQ(next(stuck, "status")["id"], "dropped") << "once it reads on, it is told";
}

TEST_F(ServerTest, SilentViewersAreGone) {
  auto quick = options();
  quick.idle_timeout = 200ms;
  const Server server(quick, {});
  WebSocketClient silent(server.port());  // answers no ping while it does not read
  ASSERT_TRUE(eventually([&] { return server.viewers() == 1; }));
  EXPECT_TRUE(eventually([&] { return server.viewers() == 0; }));
}

TEST_F(ServerTest, RefusesMoreViewersThanItMayHave) {
  auto few = options();
  few.most_viewers = 2;
  const Server server(few, {});
  WebSocketClient a(server.port()), b(server.port());
  EXPECT_THAT(refusal(server.port(), {"foxglove.sdk.v1", "/", {}, 0}), HasSubstr("503"));
}

TEST_F(ServerTest, SaysGoodbye) {
  auto server = std::make_unique<Server>(options(), Handlers());
  WebSocketClient client(server->port());
  std::thread end([&] { server.reset(); });
  while (client.receive()) {
  }
  end.join();
  EXPECT_EQ(client.close_code(), 1001);
}

}  // namespace
}  // namespace prehend::viewing
