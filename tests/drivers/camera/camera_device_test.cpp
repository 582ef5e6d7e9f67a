#include "drivers/camera/driver/camera_device.h"

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/drivers/eventually.h"

namespace prehend::drivers::camera {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

// What a test does to the sources of a camera.
struct Plug {
  std::atomic<bool> is_there = true;
  std::atomic<bool> is_silent = false;
  std::atomic<bool> has_controls = true;
  std::atomic<double> exposure = -1;
  std::atomic<int> opened = 0;
};

constexpr int kEndless = -1;

// A camera that is triggered each 5 ms of steady_now(), or a file of `count` frames, one each 10 ms
// from its start. A frame's colour is its number's.
class MadeUpSource : public FrameSource {
 public:
  MadeUpSource(Plug& plug, int count, Time shift, int width, Time start)
      : plug_(plug), count_(count), shift_(shift), start_(start), width_(width) {
    ++plug.opened;
  }
  std::optional<Frame> next(Time patience) override {
    if (!plug_.is_there) throw SourceLost("made-up camera was unplugged");
    if (plug_.is_silent || next_ == count_) {
      std::this_thread::sleep_for(std::min<Time>(patience, 1ms));
      return std::nullopt;
    }
    constexpr Time kTrigger = 5ms, kFilePeriod = 10ms;
    const Time now = steady_now();
    const Time due = start_ + next_ * kFilePeriod;
    if (count_ != kEndless && due > now) {
      std::this_thread::sleep_for(std::min(due - now, patience));
      return std::nullopt;
    }
    if (count_ == kEndless) {
      next_ = static_cast<int>(now / kTrigger % 1'000'000 + 1);
      std::this_thread::sleep_for(kTrigger - now % kTrigger);
    }
    Frame frame;
    frame.image = geometry::ColorImage(width_, 2, {static_cast<std::uint8_t>(next_ % 251), 0, 0});
    frame.stamp =
        (count_ == kEndless ? now - now % kTrigger + kTrigger : start_ + next_ * kFilePeriod) +
        shift_;
    frame.is_stamped_by_device = true;
    ++next_;
    return frame;
  }
  bool is_at_end() const override { return count_ != kEndless && next_ == count_; }
  bool rewind(Time start) override {
    start_ = start;
    next_ = 0;
    return true;
  }
  double rate() const override { return count_ == kEndless ? 200 : 100; }
  const std::string& name() const override { return name_; }
  std::string set_exposure(double seconds) override {
    if (!plug_.has_controls) return "made-up camera does not take an exposure";
    plug_.exposure = seconds;
    return "";
  }
  std::string set_gain(double) override { return ""; }

 private:
  Plug& plug_;
  int count_;
  int next_ = 0;
  Time shift_, start_;
  int width_;
  std::string name_ = "made-up camera";
};

class CameraDeviceTest : public ::testing::Test {
 protected:
  void start(CameraOptions options, int count = kEndless, Time shift = 2ms, int width = 4) {
    options.retry = 0.01;
    options.grace = 0;
    device_ = std::make_unique<CameraDevice>(
        options,
        [this, count, shift, width](std::size_t source,
                                    Time begin) -> std::unique_ptr<FrameSource> {
          Plug& plug = plugs_[source];
          if (!plug.is_there)
            throw geometry::InputError("there is no made-up camera", "Plug it in");
          return std::make_unique<MadeUpSource>(plug, count, source == 1 ? shift : Time{}, width,
                                                begin);
        },
        [this](CameraView view) {
          const std::lock_guard lock(mutex_);
          views_.push_back(std::move(view));
        },
        notes_.taker());
  }
  std::size_t count() {
    const std::lock_guard lock(mutex_);
    return views_.size();
  }
  bool more_views_come() {
    const std::size_t before = count();
    return eventually([&] { return count() > before + 3; });
  }

  Plug plugs_[2];
  Notes notes_;
  std::mutex mutex_;
  std::vector<CameraView> views_;
  std::unique_ptr<CameraDevice> device_;
};

TEST_F(CameraDeviceTest, PairsAreOfOneInstant) {
  start({.kind = CameraKind::kTwo});
  ASSERT_TRUE(eventually([&] { return count() > 50; }));
  device_.reset();
  for (const CameraView& view : views_) {
    ASSERT_TRUE(view.right);
    EXPECT_EQ(view.left.data[0], view.right->data[0]);  // both are frame i
  }
  EXPECT_TRUE(views_[0].is_stamped_by_device);
}

TEST_F(CameraDeviceTest, WhatIsUnpluggedIsToldAndOpenedAgain) {
  for (const CameraKind kind : {CameraKind::kMono, CameraKind::kTwo}) {
    start({.kind = kind, .stale_time = 0.2});
    ASSERT_TRUE(more_views_come());
    for (int round = 1; round <= 5; ++round) {
      Plug& plug = plugs_[kind == CameraKind::kTwo ? round % 2 : 0];
      plug.is_there = false;
      ASSERT_TRUE(eventually(
          [&] { return device_->trouble().find("there is no made-up") != std::string::npos; }));
      plug.is_there = true;
      ASSERT_TRUE(eventually([&] { return device_->trouble().empty(); }));
      ASSERT_TRUE(more_views_come());
      EXPECT_EQ(device_->statistics().lost, static_cast<std::uint64_t>(round));
    }
    device_.reset();
  }
  EXPECT_TRUE(notes_.has("unplugged"));
}

TEST_F(CameraDeviceTest, SilenceIsAnErrorForAsLongAsItLasts) {
  start({.kind = CameraKind::kTwo, .stale_time = 0.2});
  ASSERT_TRUE(more_views_come());
  plugs_[1].is_silent = true;
  ASSERT_TRUE(eventually([&] { return !device_->trouble().empty(); }));
  EXPECT_THAT(device_->trouble(), HasSubstr("no pair for 0.2 s"));
  plugs_[1].is_silent = false;
  ASSERT_TRUE(more_views_come());
  ASSERT_TRUE(eventually([&] { return device_->trouble().empty(); }));
}

TEST_F(CameraDeviceTest, FramesTooFarApartAreNoPair) {
  start({.kind = CameraKind::kTwo, .pair_tolerance = 0.001, .stale_time = 0.05});
  ASSERT_TRUE(eventually([&] { return device_->statistics().unpaired[0] > 20; }));
  ASSERT_TRUE(eventually([&] { return !device_->trouble().empty(); }));
  EXPECT_THAT(device_->trouble(), HasSubstr("ms apart"));
  EXPECT_EQ(device_->statistics().views, 0u);
}

TEST_F(CameraDeviceTest, FilesEndOrBeginAnew) {
  start({.kind = CameraKind::kTwo}, 20, 0ms);
  ASSERT_TRUE(eventually([&] { return device_->is_at_end(); }));
  EXPECT_EQ(count(), 20u);
  EXPECT_EQ(device_->trouble(), "");
  EXPECT_TRUE(notes_.has("at its end"));
  device_.reset();
  views_.clear();
  start({.kind = CameraKind::kTwo, .loop = true}, 20, 0ms);
  ASSERT_TRUE(eventually([&] { return count() > 100; }));
  const CameraStatistics statistics = device_->statistics();
  EXPECT_EQ(statistics.unpaired[0] + statistics.unpaired[1], 0u);
  device_.reset();
  for (const CameraView& view : views_) EXPECT_EQ(view.left.data[0], view.right->data[0]);
}

TEST_F(CameraDeviceTest, ViewsAreThinnedByTheirStamps) {
  start({.most_rate = 10}, 100);  // of 100 a second
  ASSERT_TRUE(eventually([&] { return device_->is_at_end(); }));
  EXPECT_EQ(count(), 10u);
  EXPECT_EQ(device_->statistics().views, 100u);
}

TEST_F(CameraDeviceTest, ControlsMayBeSetWhileItRuns) {
  start({.exposure = 0.02});
  ASSERT_TRUE(eventually([&] { return plugs_[0].exposure == 0.02; }));
  device_->set_exposure(0.01);
  ASSERT_TRUE(eventually([&] { return plugs_[0].exposure == 0.01; }));
  plugs_[0].has_controls = false;
  device_->set_exposure(0.03);
  ASSERT_TRUE(eventually([&] { return !device_->remark().empty(); }));
  EXPECT_EQ(device_->trouble(), "");
  plugs_[0].has_controls = true;
  device_->set_exposure(0.03);
  ASSERT_TRUE(eventually([&] { return device_->remark().empty(); }));
}

TEST_F(CameraDeviceTest, AnOddSideBySideImageIsToldAndOthersAreHalved) {
  start({.kind = CameraKind::kSideBySide}, kEndless, 0ms, 5);
  ASSERT_TRUE(eventually([&] { return notes_.has("5 pixels' width"); }));
  EXPECT_EQ(count(), 0u);
  device_.reset();
  Frame frame;
  frame.image = geometry::ColorImage(6, 2);
  for (int i = 0; i < 12; ++i)
    frame.image.data[static_cast<std::size_t>(i)] = {static_cast<std::uint8_t>(i), 0, 0};
  const CameraView view = split_side_by_side(frame);
  EXPECT_EQ(view.left.at(2, 1)[0], 8);
  EXPECT_EQ(view.right->at(0, 0)[0], 3);
  EXPECT_EQ(view.right->at(2, 1)[0], 11);
}

TEST_F(CameraDeviceTest, OptionsThatCannotBeAreRefused) {
  EXPECT_THROW(start({.most_rate = -1}), std::invalid_argument);
  EXPECT_THROW(start({.pair_tolerance = 2}), std::invalid_argument);
  EXPECT_THROW(start({.stale_time = 0}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::drivers::camera
