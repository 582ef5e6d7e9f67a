// The nodes pad_touch and touch_recognition as processes, fed with what real or simulated pads and
// a gripper publish.

#include <chrono>
#include <cmath>
#include <fstream>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/robot/without_pads.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::HasSubstr;

class TouchNodes : public ::testing::Test {
 protected:
  TouchNodes() : node_(options()) {
    for (const char* pad : {"left", "right"}) {
      pads_.push_back(node_.advertise<msgs::TactileFrame>(std::string("/tactile/") + pad,
                                                          graph::QoS::queue(50)));
    }
    gripper_ = node_.advertise<msgs::GripperState>("/gripper/state", graph::QoS::queue(50));
    touch_ = node_.subscribe<msgs::Touch>("/touch", graph::QoS::queue(50), [this](const auto& m) {
      const std::lock_guard lock(mutex_);
      heard_ = *m;
    });
    timer_ = node_.create_timer(0.02, [this] { publish(); });
    node_.spin_in_background();
  }
  ~TouchNodes() override { timer_ = {}; }

  void start(const std::string& program, const std::vector<std::string>& parameters) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    process_.emplace(program, arguments, scratch_.path() / "output.txt");
  }

  /// What touch_recognition says when it ends at once.
  std::string refusal(const std::string& parameter) {
    const auto end = run_program("touch_recognition",
                                 {"--registry", registry_.endpoint(), "--param", parameter}, 20s);
    EXPECT_TRUE(end.exit_code && *end.exit_code != 0) << parameter;
    return end.output;
  }

  /// What the hand holds from now on: a ball [m], or nothing.
  void hold(double radius) {
    {
      const std::lock_guard lock(mutex_);
      radius_ = radius;
      heard_.reset();
    }
    std::this_thread::sleep_for(200ms);
  }

  template <class Request, class Response>
  Response call(const std::string& service, const Request& request) {
    auto client = node_.client<Request, Response>(service);
    const auto outcome = client.call(request, 20s);
    EXPECT_TRUE(outcome.ok()) << service << ": " << outcome.error();
    return outcome.ok() ? *outcome : Response();
  }
  msgs::TouchMemory named(const std::string& what, const std::string& name) {
    msgs::NamedThing thing;
    thing.set_name(name);
    return call<msgs::NamedThing, msgs::TouchMemory>("/touch_recognition/" + what, thing);
  }
  msgs::TouchMemory file(const std::string& what) {
    return call<msgs::TouchMemoryFile, msgs::TouchMemory>("/touch_recognition/" + what, {});
  }
  msgs::TouchAnswer ask(bool more = false) {
    msgs::TouchQuestion question;
    question.set_more(more);
    return call<msgs::TouchQuestion, msgs::TouchAnswer>("/touch_recognition/ask", question);
  }
  /// Until the node has heard of pads and gripper.
  void wait_until_it_feels() {
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (std::chrono::steady_clock::now() < end) {
      const std::string reason = ask().reason();
      if (reason.find("nobody has published") == std::string::npos) return;
      std::this_thread::sleep_for(20ms);
    }
    FAIL() << "it hears nothing";
  }
  /// The answer once it is `name`, or the last one: what is held is heard of a little later.
  msgs::TouchAnswer ask_until(const std::string& name) {
    const auto end = std::chrono::steady_clock::now() + 20s;
    msgs::TouchAnswer answer = ask();
    while ((!answer.success() || answer.name() != name) && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(20ms);
      answer = ask();
    }
    return answer;
  }
  std::optional<msgs::Touch> heard() {
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (heard_ && heard_->pads_size() == 2) return heard_;
      }
      std::this_thread::sleep_for(10ms);
    }
    return std::nullopt;
  }

  ScratchFolder scratch_;

 private:
  graph::NodeOptions options() const {
    graph::NodeOptions result;
    result.name = "robot";
    result.registry = registry_.endpoint();
    return result;
  }

  void publish() {
    double radius = 0;
    {
      const std::lock_guard lock(mutex_);
      radius = radius_;
    }
    const std::int64_t stamp = node_.clock().now();
    ++count_;
    msgs::TactileFrame frame;
    frame.mutable_header()->set_stamp(stamp);
    frame.set_rows(14);
    frame.set_columns(6);
    frame.set_texel_width(0.0034);
    frame.set_texel_height(0.0034);
    frame.set_full_scale(4095);
    frame.set_newton_per_count(0.000706);
    const double y0 = 0.001 * (count_ % 7);  // held a little elsewhere each time
    for (int i = 0; i < 84; ++i) {
      const double x = (i % 6 - 2.5) * 0.0034, y = (6.5 - i / 6) * 0.0034 - y0;
      const double depth = 0.0014 - (x * x + y * y) / (2 * radius);
      frame.add_intensity(
          radius > 0 && depth > 0 ? static_cast<std::uint32_t>(1000 * depth / 0.000706) : 0);
    }
    for (const auto& pad : pads_) pad.publish(frame);
    msgs::GripperState state;
    state.mutable_header()->set_stamp(stamp);
    state.set_opening(radius > 0 ? 2 * radius - 0.0028 + 1e-5 * (count_ % 5) : 0.069);
    gripper_.publish(state);
  }

  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  graph::Node node_;
  std::vector<graph::Publisher<msgs::TactileFrame>> pads_;
  graph::Publisher<msgs::GripperState> gripper_;
  std::mutex mutex_;
  double radius_ = 0;  // m
  int count_ = 0;
  std::optional<msgs::Touch> heard_;
  graph::Subscription touch_;
  graph::Node::Timer timer_;
  std::optional<Launched> process_;
};

TEST_F(TouchNodes, WhatPadsFeelIsSaidOfBothPads) {
  start("pad_touch", {"friction:=0.5"});
  hold(0.02);
  const auto touch = heard();
  ASSERT_TRUE(touch);
  ASSERT_EQ(touch->pads_size(), 2);
  for (const msgs::PadTouch& pad : touch->pads()) {
    EXPECT_EQ(pad.texels(), 84u);
    ASSERT_TRUE(pad.has_curvature()) << pad.DebugString();
    EXPECT_NEAR(pad.curvature().largest(), 50, 5);
    EXPECT_NEAR(pad.center().x(), 0, 1e-4);
    EXPECT_NEAR(pad.normal().direction().z(), 1, 1e-3);
    EXPECT_GT(pad.holding_torque(), 0);
    EXPECT_EQ(pad.friction(), 0.5);
    EXPECT_EQ(pad.slip().texels().rows_size(), 14);
  }
  hold(0);
  const auto nothing = heard();
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(nothing->pads(0).has_center());
  EXPECT_THAT(nothing->pads(0).not_determined(), Contains(HasSubstr("nothing touches")));
}

TEST_F(TouchNodes, RecognitionIsTaughtAskedSavedAndForgotten) {
  const std::string memory = (scratch_.path() / "memory.yaml").string();
  start("touch_recognition", {"memory:=" + memory, "stale_time:=20"});
  wait_until_it_feels();
  hold(0);
  const auto air = named("teach", "air");
  EXPECT_FALSE(air.success());
  EXPECT_THAT(air.reason(), HasSubstr("no pad touches anything"));
  for (const auto& [name, radius] : {std::pair{"plum", 0.018}, {"apple", 0.03}}) {
    hold(radius);
    for (int k = 0; k < 6; ++k) {
      EXPECT_TRUE(named("teach", name).success());
      std::this_thread::sleep_for(50ms);
    }
  }
  hold(0.018);
  EXPECT_EQ(ask_until("plum").name(), "plum");
  hold(0.03);
  const msgs::TouchAnswer two = ask_until("apple");
  EXPECT_EQ(two.name(), "apple");
  EXPECT_EQ(two.presses(), 1u);
  ASSERT_EQ(two.candidates_size(), 2);
  EXPECT_EQ(ask(true).presses(), 2u);
  hold(0.024);
  const msgs::TouchAnswer other = ask_until("");
  EXPECT_TRUE(other.success());
  EXPECT_EQ(other.name(), "");
  EXPECT_THAT(other.reason(), HasSubstr("likest"));
  EXPECT_TRUE(file("save").success());

  // Forgotten, and remembered by the file; also by another process.
  EXPECT_EQ(named("forget", "plum").things_size(), 1);
  EXPECT_FALSE(named("forget", "plum").success());
  hold(0.018);
  EXPECT_EQ(ask_until("").name(), "");
  EXPECT_EQ(file("load").things_size(), 2);
  EXPECT_EQ(ask_until("plum").name(), "plum");
  start("touch_recognition", {"memory:=" + memory, "stale_time:=20"});
  wait_until_it_feels();
  EXPECT_EQ(ask_until("plum").name(), "plum");
}

TEST_F(TouchNodes, RecognitionRefusesWhatItCannotUse) {
  const auto bare = platform_without_pads(scratch_.path() / "robots");
  EXPECT_THAT(refusal("platform:=" + bare.string()), HasSubstr("has no tactile pads"));
  EXPECT_THAT(refusal("pads:=[lefd]"), HasSubstr("'lefd' is no pad of stage_pg70"));
  EXPECT_THAT(refusal("by:=smell"), HasSubstr("smell"));
  const auto memory = scratch_.path() / "broken.yaml";
  std::ofstream(memory)
      << "version: 1\nlayouts: []\nthings: [{name: plum, presses: [{features: 'x'}]}]";
  EXPECT_THAT(refusal("memory:=" + memory.string()), HasSubstr("is no row of numbers"));
}

}  // namespace
}  // namespace prehend::testing
