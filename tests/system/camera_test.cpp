// Live cameras as real processes: the simulated scene through OpenNI2, and videos of it through the
// node of stereo cameras, until the objects are found where they stand.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "drivers/wire/stream/tcp_server.h"
#include "msgs/convert/geometry.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/perception/camera_calibration.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/stereo_renderer.h"
#include "prehend/simulation/world.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

// A port of this host that is free now.
std::string free_port() {
  const std::string name = drivers::TcpServer().name();
  return name.substr(name.rfind(':') + 1);
}

std::string pose_text(const geometry::RigidTransform& X_WC) {
  const Eigen::Quaterniond q(X_WC.linear());
  const Eigen::Vector3d& p = X_WC.translation();
  std::string text = "[";
  for (const double value : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}) {
    text += (text.size() > 1 ? ", " : "") + std::to_string(value);
  }
  return text + "]";
}

class CameraGraph : public ::testing::Test {
 protected:
  CameraGraph()
      : scene_(simulation::read_scene("config/scenes/demo.yaml")),
        pose_(pose_text(scene_.camera.X_WC())) {}

  void listen(const std::string& registry, graph::ClockMode clock) {
    graph::NodeOptions options;
    options.name = "test";
    options.registry = registry;
    options.clock = clock;
    options.registry_timeout = seconds(30);
    node_ = std::make_unique<graph::Node>(options);
    objects_subscription_ = node_->subscribe<msgs::ObjectHypotheses>(
        "/objects", graph::QoS::latched(1),
        [this](const graph::Received<msgs::ObjectHypotheses>& m) {
          const std::lock_guard lock(mutex_);
          objects_ = *m;
          ++count_;
        });
    device_subscription_ =
        node_->subscribe<msgs::DeviceStatus>("/camera/device", graph::QoS::latched(1),
                                             [this](const graph::Received<msgs::DeviceStatus>& m) {
                                               const std::lock_guard lock(mutex_);
                                               device_ = *m;
                                             });
    node_->spin_in_background();
  }

  bool eventually(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + seconds(60);
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (condition()) return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  // The objects that were found are those of the scene: as many, each with its seen points around
  // where one stands.
  void expect_scene() {
    ASSERT_TRUE(eventually([this] { return count_ > 0; }));
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(objects_.problem(), "");
    ASSERT_EQ(static_cast<std::size_t>(objects_.objects_size()), scene_.objects.size());
    for (const simulation::SceneObject& object : scene_.objects) {
      double nearest = 1;
      for (const msgs::ObjectHypothesis& found : objects_.objects()) {
        const Eigen::Vector3d middle = geometry::centroid(convert::from_message(found.cloud()));
        nearest = std::min(nearest, std::hypot(middle.x() - object.x, middle.y() - object.y));
      }
      EXPECT_LT(nearest, 0.05) << object.name;  // only the side to the camera is seen
    }
  }

  simulation::Scene scene_;
  std::string pose_;
  ScratchFolder scratch_;
  std::mutex mutex_;
  msgs::ObjectHypotheses objects_;
  msgs::DeviceStatus device_;
  int count_ = 0;
  std::unique_ptr<graph::Node> node_;
  graph::Subscription objects_subscription_, device_subscription_;
};

TEST_F(CameraGraph, TheSimulatedSceneComesThroughOpenNI) {
  const std::string registry = drivers::TcpServer().name();
  Launched launch(
      "prehend",
      {"launch", "launch/emulated_camera.yaml", "port:=" + free_port(), "camera_rate:=1",
       "--registry", registry, "--log-dir", (scratch_.path() / "log").string()},
      scratch_.path() / "launch.txt");
  listen(registry, graph::ClockMode::kSimulated);
  expect_scene();
  const auto unplug = [&](const char* value) {
    const Outcome set = run_program(
        "prehend",
        {"param", "set", "depth_camera_emulator", "unplugged", value, "--registry", registry},
        seconds(30));
    EXPECT_EQ(set.exit_code, 0) << set.output;
  };
  unplug("true");
  EXPECT_TRUE(eventually([this] { return device_.state() == "no images"; })) << launch.output();
  const Outcome nodes =
      run_program("prehend", {"node", "list", "--registry", registry}, seconds(30));
  EXPECT_THAT(nodes.output, HasSubstr("error: "));
  unplug("false");
  EXPECT_TRUE(eventually([this] { return device_.state() == "streaming"; })) << launch.output();
  {
    const std::lock_guard lock(mutex_);
    count_ = 0;
  }
  expect_scene();
  launch.send_signal(SIGINT);
  EXPECT_EQ(launch.wait(seconds(30)), 0) << launch.output();
}

class StereoVideo : public CameraGraph {
 protected:
  StereoVideo() : registry_({.endpoint = "tcp://127.0.0.1:*"}) {
    static const simulation::StereoImages images =
        simulation::render_stereo(scene_, simulation::World(scene_).visible_bodies());
    const auto picture = [](const geometry::ColorImage& image) {
      cv::Mat bgr;
      cv::cvtColor(cv::Mat(image.height, image.width, CV_8UC3,
                           const_cast<void*>(static_cast<const void*>(image.data.data()))),
                   bgr, cv::COLOR_RGB2BGR);
      return bgr;
    };
    const cv::Mat left = picture(images.left), right = picture(images.right);
    cv::Mat both;
    cv::hconcat(left, right, both);
    write_video("left.avi", left);
    write_video("right.avi", right);
    write_video("both.avi", both);
    perception::StereoCalibration calibration;
    const geometry::PinholeCamera& camera = scene_.camera.camera.left;
    calibration.width = camera.width;
    calibration.height = camera.height;
    calibration.K_left << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    calibration.K_right = calibration.K_left;
    calibration.X_RL.translation().x() = -scene_.camera.camera.baseline;
    const auto [left_camera, right_camera] = perception::camera_calibrations(calibration);
    perception::write_camera_calibration(path("left.yaml"), left_camera);
    perception::write_camera_calibration(path("right.yaml"), right_camera);
  }

  std::string path(const std::string& name) const { return scratch_.path() / name; }
  void write_video(const std::string& name, const cv::Mat& image) const {
    cv::VideoWriter writer(path(name), cv::CAP_OPENCV_MJPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 20, image.size());
    writer.set(cv::VIDEOWRITER_PROP_QUALITY, 98);
    for (int i = 0; i < 10; ++i) writer.write(image);
  }

  void run(const std::vector<std::string>& parameters) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    Launched camera("camera", arguments, path("camera.txt"));
    Launched segmentation("stereo_segmentation", {"--registry", registry_.endpoint()},
                          path("segmentation.txt"));
    listen(registry_.endpoint(), graph::ClockMode::kWall);
    expect_scene();
    EXPECT_TRUE(eventually([this] { return device_.state() == "at the end"; })) << camera.output();
    {
      const std::lock_guard lock(mutex_);
      EXPECT_EQ(device_.messages() + device_.damaged(), 10u);
    }
    for (Launched* program : {&camera, &segmentation}) {
      program->send_signal(SIGINT);
      EXPECT_EQ(program->wait(seconds(20)), 0) << program->output();
    }
  }

  graph::Registry registry_;
};

TEST_F(StereoVideo, OfTwoCamerasShowsTheScene) {
  run({"kind:=stereo", "source:=" + path("left.avi"), "right_source:=" + path("right.avi"),
       "calibration:=" + scratch_.path().string(), "pose:=" + pose_});
}

TEST_F(StereoVideo, OfASideBySideCameraShowsTheScene) {
  run({"kind:=side_by_side", "source:=" + path("both.avi"),
       "calibration:=" + scratch_.path().string(), "pose:=" + pose_});
}

TEST_F(StereoVideo, WhatDoesNotFitIsSaid) {
  const auto output_of = [&](std::vector<std::string> parameters) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    const Outcome outcome = run_program("camera", arguments, seconds(30));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    return outcome.output;
  };
  EXPECT_THAT(output_of({"kind:=stereo", "source:=" + path("left.avi")}),
              HasSubstr("right_source is empty"));
  EXPECT_THAT(output_of({"source:=a", "right_source:=b"}), HasSubstr("kind is mono"));
  EXPECT_THAT(output_of({"kind:=side_by_side", "source:=" + path("both.avi")}),
              HasSubstr("calibration is empty"));
  EXPECT_THAT(output_of({"kind:=side_by_side", "calibration:=" + path("left.yaml")}),
              HasSubstr("of one camera"));
  EXPECT_THAT(output_of({"source:=left.avi", "width:=640"}), HasSubstr("asked of devices"));
}

// A camera that is not there is an error of a living node, until it is there.
TEST_F(StereoVideo, ACameraThatIsNotThereIsWaitedFor) {
  Launched camera("camera",
                  {"--registry", registry_.endpoint(), "--param", "source:=" + path("later.avi")},
                  path("camera.txt"));
  listen(registry_.endpoint(), graph::ClockMode::kWall);
  ASSERT_TRUE(eventually([this] { return device_.state() == "no images"; })) << camera.output();
  EXPECT_TRUE(camera.wait_for_output("there is no video", seconds(20)));
  std::filesystem::rename(path("left.avi"), path("later.avi"));
  EXPECT_TRUE(eventually([this] { return device_.messages() > 0; })) << camera.output();
}

}  // namespace
}  // namespace prehend::testing
