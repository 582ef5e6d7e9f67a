#include "drivers/camera/transport/video_source.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "drivers/camera/driver/camera_device.h"
#include "prehend/geometry/errors.h"
#include "tests/drivers/eventually.h"

namespace prehend::drivers::camera {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kFrames = 12;

class VideoSource : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = std::filesystem::temp_directory_path() / "prehend-videos-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Frame i is red 20 * i, green 100, and blue 200 in the left half, 50 in the right one.
  static cv::Mat picture(int i) {
    cv::Mat image(48, 64, CV_8UC3, cv::Scalar(50, 100, 20 * i));
    image.colRange(0, 32).setTo(cv::Scalar(200, 100, 20 * i));
    return image;
  }
  std::string write_video(const std::string& name, double rate) const {
    const std::string file = folder_ / name;
    cv::VideoWriter writer(file, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           rate, cv::Size(64, 48));
    EXPECT_TRUE(writer.isOpened());
    for (int i = 0; i < kFrames; ++i) writer.write(picture(i));
    return file;
  }
  static std::string error_of(const VideoOptions& options) {
    try {
      open_video_source(options);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "no error";
  }
  std::string write_text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  std::filesystem::path folder_;
};

void expect_frames(FrameSource& source, double rate, Time start) {
  int i = 0;
  while (!source.is_at_end()) {
    const auto frame = source.next(20ms);
    if (!frame) continue;
    EXPECT_EQ(frame->image.width, 64);
    EXPECT_NEAR(frame->image.at(8, 8)[0], 20 * i, 12);  // JPEG
    EXPECT_NEAR(frame->image.at(8, 8)[2], 200, 12);
    EXPECT_NEAR(frame->image.at(56, 8)[2], 50, 12);
    EXPECT_NEAR(to_seconds(frame->stamp - start), i / rate, 1e-6);
    EXPECT_GE(steady_now(), frame->stamp);  // not before it is due
    ++i;
  }
  EXPECT_EQ(i, kFrames);
}

TEST_F(VideoSource, AVideoIsPlayedAtItsRate) {
  const Time start = steady_now();
  const auto source = open_video_source({.address = write_video("a.avi", 100), .start = start});
  EXPECT_NEAR(source->rate(), 100, 0.1);
  expect_frames(*source, 100, start);
  EXPECT_FALSE(source->next(1ms));
  const Time again = steady_now();
  EXPECT_TRUE(source->rewind(again));
  expect_frames(*source, 100, again);
  EXPECT_THAT(source->set_exposure(0.01), HasSubstr("exposed already"));
}

TEST_F(VideoSource, ASequenceOfImagesIsPlayedAtTheRateGiven) {
  for (int i = 0; i < kFrames; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "left_%04d.png", i);
    cv::imwrite(folder_ / name, picture(i));
  }
  const Time start = steady_now();
  const auto source =
      open_video_source({.address = folder_ / "left_%04d.png", .rate = 200, .start = start});
  expect_frames(*source, 200, start);
}

TEST_F(VideoSource, TwoVideosArePairedFrameByFrame) {
  const std::string left = write_video("l.avi", 100), right = write_video("r.avi", 100);
  std::mutex mutex;
  std::vector<CameraView> views;
  Notes notes;
  CameraDevice device(
      {.kind = CameraKind::kTwo},
      [&](std::size_t source, Time start) {
        return open_video_source({.address = source == 0 ? left : right, .start = start});
      },
      [&](CameraView view) {
        const std::lock_guard lock(mutex);
        views.push_back(std::move(view));
      },
      notes.taker());
  ASSERT_TRUE(eventually([&] { return device.is_at_end(); }));
  const std::lock_guard lock(mutex);
  ASSERT_EQ(views.size(), static_cast<std::size_t>(kFrames));
  for (const CameraView& view : views) EXPECT_EQ(view.left.data, view.right->data);
}

TEST_F(VideoSource, SaysWhatIsWrong) {
  EXPECT_THAT(error_of({.address = ""}), HasSubstr("no camera is named"));
  EXPECT_THAT(error_of({.address = "/dev/video97"}),
              AllOf(HasSubstr("/dev/video97"), HasSubstr("there is no camera")));
  EXPECT_THAT(error_of({.address = "/dev/null"}), HasSubstr("/dev/null is no camera"));
  EXPECT_THAT(error_of({.address = "/dev"}), HasSubstr("there is no video"));
  EXPECT_THAT(error_of({.address = folder_ / "none.avi"}), HasSubstr("there is no video"));
  EXPECT_THAT(error_of({.address = folder_ / "none_%04d.png"}), HasSubstr("cannot be read"));
  EXPECT_THAT(error_of({.address = write_text("empty.avi", "")}), HasSubstr("cannot be read"));
  EXPECT_THAT(error_of({.address = write_text("text.avi", "hello")}), HasSubstr("cannot be read"));
  EXPECT_THAT(error_of({.address = write_video("a.avi", 30), .width = 640}),
              HasSubstr("no device that could be asked"));
  EXPECT_THAT(error_of({.address = "/dev/video0", .format = "MJPEG"}), HasSubstr("four letters"));
}

// Cut and disturbed at random places: frames, the end or a clear loss, never more, and no crash.
TEST_F(VideoSource, ADamagedVideoEndsOrIsLost) {
  std::ifstream stream(write_video("a.avi", 1000), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  for (unsigned trial = 0; trial < 14; ++trial) {
    std::string text = whole.substr(0, whole.size() * (trial % 6 + 1) / 6);
    for (unsigned i = 0; trial >= 6 && i < 40; ++i) {
      text[(trial * 7919 + i * 104729) % text.size()] ^= static_cast<char>(1 + i);
    }
    try {
      const auto source =
          open_video_source({.address = write_text("damaged.avi", text), .start = steady_now()});
      int frames = 0;
      for (int i = 0; i < 200 && !source->is_at_end(); ++i) {
        frames += source->next(5ms).has_value() ? 1 : 0;
      }
      EXPECT_LE(frames, kFrames);
    } catch (const geometry::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("damaged.avi"));
    } catch (const SourceLost& error) {
      EXPECT_THAT(error.what(), HasSubstr("damaged.avi"));
    }
  }
}

}  // namespace
}  // namespace prehend::drivers::camera
