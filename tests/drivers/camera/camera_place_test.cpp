// Where a camera on an arm was when a picture was taken, as the graph says.

#include "drivers/camera/node/camera_place.h"

#include <chrono>
#include <thread>

#include <gmock/gmock.h>

#include "prehend/geometry/errors.h"
#include "prehend/graph/registry.h"

namespace prehend::drivers::camera {
namespace {

using ::testing::HasSubstr;

class CameraPlaceTest : public ::testing::Test {
 protected:
  graph::NodeOptions options(const std::string& name) const {
    graph::NodeOptions options;
    options.name = name;
    options.registry = registry_.endpoint();
    return options;
  }
  std::string refusal(const std::map<std::string, std::string>& parameters) {
    graph::NodeOptions given = options("camera_" + std::to_string(++cameras_));
    given.parameters = parameters;
    try {
      graph::Node node(given);
      const CameraPlace place(node);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  int cameras_ = 0;
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
};

TEST_F(CameraPlaceTest, GoesAlongWithTheArm) {
  constexpr std::int64_t kMs = 1'000'000;
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh_camera.yaml");
  const robot::KinematicChain chain = platform.arm_chain();
  graph::NodeOptions given = options("camera");
  given.parameters = {{"platform", "kr5_sdh_camera"}, {"platforms", "config/robots"}};
  graph::Node node(given);
  const CameraPlace place(node);
  EXPECT_TRUE(place.is_carried());
  EXPECT_FALSE(place.fixed());
  EXPECT_THROW(place.at(5 * kMs), geometry::InputError) << "nobody has said where the arm is";
  graph::Node arm(options("arm"));
  const auto states = arm.advertise<msgs::JointState>("/joint_states", graph::QoS::latched(10));
  const robot::Positions home = platform.home("home").arm, side = platform.home("side").arm;
  for (int i = 0; i <= 4; ++i) {
    msgs::JointState message;
    message.mutable_header()->set_stamp(i * 10 * kMs);
    for (int j = 0; j < chain.size(); ++j) {
      message.add_name(chain.joints()[static_cast<std::size_t>(j)].name);
      message.add_position(home[j] + 0.25 * i * (side[j] - home[j]));
    }
    states.publish(std::move(message));
  }
  node.spin_in_background();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < end) {
    try {
      place.at(39 * kMs);
      break;
    } catch (const geometry::InputError&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  EXPECT_TRUE(place.at(0)->isApprox(platform.X_WC(home), 1e-9));
  EXPECT_TRUE(place.at(40 * kMs)->isApprox(platform.X_WC(side), 1e-9));
  EXPECT_TRUE(place.at(15 * kMs)->isApprox(platform.X_WC(home + 0.375 * (side - home)), 1e-9));
  try {
    place.at(200 * kMs);
    FAIL() << "the arm has not spoken for long";
  } catch (const geometry::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/joint_states"));
  }
}

TEST_F(CameraPlaceTest, WhatSaysNoPlaceOrTwoIsRefused) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({{"pose", "[0, 0, 1, 1, 0, 0, 0]"}}), "");
  EXPECT_THAT(refusal({{"pose", "[0, 0, 1]"}}), HasSubstr("not seven numbers"));
  EXPECT_THAT(refusal({{"pose", "[0, 0, 1, 2, 0, 0, 0]"}}), HasSubstr("norm is not 1"));
  EXPECT_THAT(refusal({{"platform", "kr5_sdh"}, {"platforms", "config/robots"}}),
              HasSubstr("carries no camera"));
  EXPECT_THAT(refusal({{"platform", "kr5_sdh_camera"},
                       {"platforms", "config/robots"},
                       {"pose", "[0, 0, 1, 1, 0, 0, 0]"}}),
              HasSubstr("both say where the camera is"));
}

}  // namespace
}  // namespace prehend::drivers::camera
