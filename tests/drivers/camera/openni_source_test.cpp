// Through the real library: OpenNI2 loads the emulated camera's driver from the folder that this
// test's rpath names, and DepthServer stands in for the graph behind it.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <OpenNI.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/camera/driver/depth_device.h"
#include "drivers/camera/driver/probe.h"
#include "drivers/camera/emulator/depth_server.h"
#include "drivers/camera/transport/depth_source.h"
#include "prehend/geometry/errors.h"
#include "tests/drivers/eventually.h"

namespace prehend::drivers::camera {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 160, kHeight = 120;
constexpr double kFx = 140, kFy = 142;  // pixels

// A wall at 1.2345 m with a box's face at 0.8 m before it; the box is red.
DepthPicture scene_picture(double box = 0.8) {
  DepthPicture picture;
  picture.width = kWidth;
  picture.height = kHeight;
  picture.fx = kFx;
  picture.fy = kFy;
  picture.cx = kWidth / 2.0;
  picture.cy = kHeight / 2.0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool is_box = u >= 60 && u < 100 && v >= 40 && v < 80;
      picture.depth.push_back(
          static_cast<std::uint16_t>(std::lround((is_box ? box : 1.2345) * 1e4)));
      for (const int channel : {is_box ? 200 : 10, 20, 30}) {
        picture.color.push_back(static_cast<std::uint8_t>(channel));
      }
    }
  }
  picture.depth[0] = 0;
  return picture;
}

class Openni : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-openni-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    server_ = std::make_unique<DepthServer>(std::uint16_t{0});
    server_->show(scene_picture());
    uri_ = "prehend://" + server_->address();
  }
  void TearDown() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }
  static std::string error_of(const OpenniOptions& options) {
    try {
      open_openni_source(options);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "no error";
  }
  static std::optional<DepthView> view_of(DepthSource& source) {
    std::optional<DepthView> view;
    eventually([&] { return (view = source.next(50ms)).has_value() || source.is_at_end(); });
    return view;
  }
  // A recording of the emulated camera, by OpenNI's own recorder.
  std::string record(int frames) const {
    const std::string file = folder_ / "recorded.oni";
    openni::OpenNI::initialize();
    {
      openni::Device device;
      EXPECT_EQ(device.open(uri_.c_str()), openni::STATUS_OK);
      device.setImageRegistrationMode(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR);
      openni::VideoStream depth, color;
      EXPECT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
      EXPECT_EQ(color.create(device, openni::SENSOR_COLOR), openni::STATUS_OK);
      openni::Recorder recorder;
      EXPECT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
      recorder.attach(depth);
      recorder.attach(color);
      // OpenNI's recorder begins and ends without frames coming: they may lock it and the library
      // for ever.
      EXPECT_EQ(recorder.start(), openni::STATUS_OK);
      depth.start();
      color.start();
      openni::VideoFrameRef frame;
      for (int i = 0; i < frames; ++i) depth.readFrame(&frame);
      depth.stop();
      color.stop();
      recorder.stop();
      recorder.destroy();
      depth.destroy();
      color.destroy();
    }
    openni::OpenNI::shutdown();
    return file;
  }

  std::filesystem::path folder_;
  std::unique_ptr<DepthServer> server_;
  std::string uri_;
};

void expect_scene(const DepthView& view, double unit) {
  ASSERT_EQ(view.depth.width, kWidth);
  ASSERT_EQ(view.depth.height, kHeight);
  EXPECT_NEAR(view.depth.at(80, 60), 0.8, unit / 2 + 1e-6);
  EXPECT_NEAR(view.depth.at(20, 20), 1.2345, unit / 2 + 1e-6);
  EXPECT_NEAR(view.depth.at(60, 40), 0.8, unit / 2 + 1e-6);  // registered: the box's own corner
  EXPECT_TRUE(std::isnan(view.depth.at(0, 0)));
  EXPECT_NEAR(view.camera.fx, kFx, 1e-3);
  EXPECT_NEAR(view.camera.fy, kFy, 1e-3);
  EXPECT_EQ(view.camera.cx, kWidth / 2.0);
}

TEST_F(Openni, DepthIsInMetresAndRegisteredToTheColour) {
  const auto source = open_openni_source({.uri = uri_, .exposure = 0.01, .gain = 0});
  EXPECT_EQ(source->refused(), "");
  EXPECT_EQ(source->rate(), 30);
  EXPECT_THAT(source->name(), HasSubstr("prehend simulated depth camera"));
  const Time before = steady_now();
  const auto view = view_of(*source);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->unit, 1e-4);  // the finer of its two
  expect_scene(*view, 1e-4);
  EXPECT_EQ(view->color.at(80, 60), (geometry::Rgb{200, 20, 30}));
  EXPECT_EQ(view->color.at(59, 40), (geometry::Rgb{10, 20, 30}));
  EXPECT_GT(view->stamp, before - 100ms);
  EXPECT_LE(view->stamp, steady_now());
}

// Without colour nothing is registered: the depth sensor stands 25 mm to the left.
TEST_F(Openni, DepthAloneIsTheDepthSensorsOwn) {
  const auto source = open_openni_source({.uri = uri_, .color = false});
  const auto view = view_of(*source);
  ASSERT_TRUE(view);
  EXPECT_TRUE(view->color.empty());
  const int shift = static_cast<int>(std::lround(kFx * 0.025 / 0.8));
  EXPECT_EQ(shift, 4);
  EXPECT_NEAR(view->depth.at(60 + shift, 40), 0.8, 1e-3);
  EXPECT_FALSE(view->depth.at(60 + shift - 1, 40) < 1);
}

TEST_F(Openni, WhatTheCameraSeesNextComesNext) {
  const auto source = open_openni_source({.uri = uri_});
  ASSERT_TRUE(view_of(*source));
  server_->show(scene_picture(0.6));
  EXPECT_TRUE(eventually([&] {
    const auto view = view_of(*source);
    return view && std::abs(view->depth.at(80, 60) - 0.6) < 1e-3;
  }));
}

TEST_F(Openni, HotUnplugAndReplug) {
  std::mutex mutex;
  std::size_t views = 0;
  Notes notes;
  DepthDevice device(
      {.retry = 0.02, .grace = 0}, [&] { return open_openni_source({.uri = uri_}); },
      [&](DepthView) {
        const std::lock_guard lock(mutex);
        ++views;
      },
      notes.taker());
  const auto more_come = [&] {
    std::size_t before = 0;
    {
      const std::lock_guard lock(mutex);
      before = views;
    }
    return eventually([&] {
      const std::lock_guard lock(mutex);
      return views > before + 2;
    });
  };
  ASSERT_TRUE(more_come());
  for (std::uint64_t round = 1; round <= 2; ++round) {
    server_->set_unplugged(true);
    ASSERT_TRUE(eventually(
        [&] { return device.trouble().find("Connection refused") != std::string::npos; }));
    server_->set_unplugged(false);
    ASSERT_TRUE(more_come());
    EXPECT_EQ(device.trouble(), "");
    EXPECT_GE(device.statistics().lost, round);
  }
  EXPECT_TRUE(notes.has("was unplugged"));
  // One that holds its line but says nothing is lost, too.
  const std::uint64_t before_silence = device.statistics().lost;
  server_->set_silent(true);
  ASSERT_TRUE(eventually([&] { return device.statistics().lost > before_silence; }));
  server_->set_silent(false);
  ASSERT_TRUE(more_come());
}

TEST_F(Openni, ManyOpeningsLeaveNothingBehind) {
  for (int i = 0; i < 4; ++i) {
    const auto source = open_openni_source({.uri = uri_, .color = i % 2 == 0});
    EXPECT_TRUE(i % 3 != 0 || view_of(*source));
  }
}

TEST_F(Openni, SaysWhatIsWrong) {
  openni::OpenNI::initialize();  // counted: what follows need not look for all devices each time
  EXPECT_THAT(error_of({.uri = "prehend://127.0.0.1:1"}), HasSubstr("Connection refused"));
  EXPECT_THAT(error_of({.uri = "prehend://"}), HasSubstr("is no address"));
  EXPECT_THAT(error_of({.uri = "1d27/0600@1/5"}), HasSubstr("1d27/0600@1/5"));
  EXPECT_THAT(error_of({.uri = "prehend://" + std::string(300, 'x')}), HasSubstr("cannot open"));
  EXPECT_THAT(error_of({.uri = folder_ / "none.oni"}), HasSubstr("there is no recording"));
  EXPECT_THAT(error_of({.uri = uri_, .width = 640, .height = 480}),
              AllOf(HasSubstr("no such mode"), HasSubstr("160 x 120 at 30/s")));
  EXPECT_THAT(error_of({.uri = uri_, .rate = 15}), HasSubstr("no such mode"));
  EXPECT_EQ(probe_depth_camera("prehend://127.0.0.1:1").result, Probe::Result::kSilent);
  const Probe answers = probe_depth_camera(uri_);
  EXPECT_EQ(answers.result, Probe::Result::kAnswers) << answers.what;
  EXPECT_THAT(answers.what, HasSubstr("160 x 120, 30/s"));
  EXPECT_FALSE(find_cameras().empty());
  for (const char* none : {"/dev/video97", "/dev/null", "/etc/hostname"}) {
    EXPECT_EQ(probe_camera(none).result, Probe::Result::kSilent) << none;
  }
  openni::OpenNI::shutdown();
}

TEST_F(Openni, ARecordingIsPlayedToItsEndOrAgain) {
  const std::string file = record(8);
  {
    const auto source = open_openni_source({.uri = file});
    int count = 0;
    while (const auto view = view_of(*source)) {
      expect_scene(*view, view->unit);
      EXPECT_EQ(view->color.at(80, 60)[0] > 150, true);
      ++count;
    }
    EXPECT_TRUE(source->is_at_end());
    EXPECT_GE(count, 4);
  }
  const auto source = open_openni_source({.uri = file, .loop = true});
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(view_of(*source)) << i;
  EXPECT_THAT(error_of({.uri = file, .width = 640}), HasSubstr("the mode it was recorded with"));
}

// Cut: frames, the end or a clear error; no crash.
TEST_F(Openni, ADamagedRecordingIsToldOrEnds) {
  std::ifstream stream(record(4), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  ASSERT_GT(whole.size(), 1000u);
  const std::string file = folder_ / "damaged.oni";
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{3}, std::size_t{100}, whole.size() / 2}) {
    std::ofstream(file, std::ios::binary) << whole.substr(0, size);
    try {
      const auto source = open_openni_source({.uri = file});
      for (int i = 0; i < 10 && !source->is_at_end(); ++i) source->next(20ms);
    } catch (const geometry::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("damaged.oni"));
    } catch (const SourceLost& error) {
      EXPECT_THAT(error.what(), HasSubstr("damaged.oni"));
    }
  }
}

}  // namespace
}  // namespace prehend::drivers::camera
