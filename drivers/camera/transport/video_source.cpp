#include "drivers/camera/transport/video_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "drivers/camera/transport/video_devices.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::camera {
namespace {

using geometry::InputError;

// A device that says nothing more is given up after so many seconds, not OpenCV's 10; read by
// OpenCV at its first device. Before any thread runs, as it changes the environment.
// What FFmpeg would print with each try is said by errors here, once (-8: AV_LOG_QUIET).
[[maybe_unused]] const bool kEnvironmentIsSet = [] {
  ::setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "2", 0);
  if (::getenv("OPENCV_FFMPEG_DEBUG") != nullptr) return true;
  ::setenv("OPENCV_FFMPEG_DEBUG", "1", 0);
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  return true;
}();

constexpr double kDefaultRate = 30;                      // 1/s, of files that do not say
constexpr double kExposureUnit = 1e-4;                   // s, V4L2_CID_EXPOSURE_ABSOLUTE
constexpr double kManualExposure = 1, kOwnExposure = 3;  // V4L2_EXPOSURE_MANUAL, _APERTURE_PRIORITY
constexpr int kLargestSide = 16384;                      // pixels, as of messages

geometry::ColorImage color_image(const cv::Mat& bgr, const std::string& name) {
  if (bgr.empty() || bgr.cols > kLargestSide || bgr.rows > kLargestSide ||
      (bgr.type() != CV_8UC3 && bgr.type() != CV_8UC1)) {
    throw SourceLost(name + " gives frames that are no 8-bit images");
  }
  geometry::ColorImage image(bgr.cols, bgr.rows);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.data.data());
  cv::cvtColor(bgr, rgb, bgr.channels() == 3 ? cv::COLOR_BGR2RGB : cv::COLOR_GRAY2RGB);
  return image;
}

/// A V4L2 device.
class DeviceSource : public FrameSource {
 public:
  explicit DeviceSource(const VideoOptions& options) : address_(options.address) {
    check_video_device(address_);
    if (!capture_.open(address_, cv::CAP_V4L2)) {
      throw InputError(address_ + " cannot be opened as a camera",
                       "It may be in use: `fuser -v " + address_ + "` says by whom");
    }
    if (!options.format.empty()) {
      const std::string& f = options.format;
      ask(cv::CAP_PROP_FOURCC, cv::VideoWriter::fourcc(f[0], f[1], f[2], f[3]), "format", f);
    }
    if (options.width > 0) ask(cv::CAP_PROP_FRAME_WIDTH, options.width, "width");
    if (options.height > 0) ask(cv::CAP_PROP_FRAME_HEIGHT, options.height, "height");
    if (options.rate > 0) ask(cv::CAP_PROP_FPS, options.rate, "rate");
    capture_.set(cv::CAP_PROP_BUFFERSIZE, 2);  // the newest frames; what refuses keeps more
    rate_ = std::max(0.0, capture_.get(cv::CAP_PROP_FPS));
    name_ = fmt::format("{}: {:.0f} x {:.0f}, {:.3g}/s", address_,
                        capture_.get(cv::CAP_PROP_FRAME_WIDTH),
                        capture_.get(cv::CAP_PROP_FRAME_HEIGHT), rate_);
  }

  std::optional<Frame> next(Time /*patience*/) override {
    cv::Mat image;
    if (!capture_.read(image)) {
      throw SourceLost(address_ + (std::filesystem::exists(address_) ? " gives no more frames"
                                                                     : " was unplugged"));
    }
    Frame frame;
    const Time now = steady_now();
    // V4L2 stamps by the monotonic clock, which is that of steady_now(); a device of another clock
    // is far off.
    const Time said = to_time(capture_.get(cv::CAP_PROP_POS_MSEC) * 1e-3);
    frame.is_stamped_by_device = said <= now && now - said < std::chrono::seconds(1);
    frame.stamp = frame.is_stamped_by_device ? said : now;
    frame.image = color_image(image, address_);
    return frame;
  }
  double rate() const override { return rate_; }
  const std::string& name() const override { return name_; }

  std::string set_exposure(double seconds) override {
    if (seconds == 0) return set(cv::CAP_PROP_AUTO_EXPOSURE, kOwnExposure, "exposure by itself");
    const std::string refused =
        set(cv::CAP_PROP_AUTO_EXPOSURE, kManualExposure, "exposure by hand");
    return refused.empty() ? set(cv::CAP_PROP_EXPOSURE, std::round(seconds / kExposureUnit),
                                 "an exposure of " + fmt::format("{:g} s", seconds))
                           : refused;
  }
  std::string set_gain(double gain) override {
    // Gain by itself goes with exposure by itself in V4L2.
    return gain == 0 ? "" : set(cv::CAP_PROP_GAIN, gain, fmt::format("a gain of {:g}", gain));
  }

 private:
  void ask(int property, double value, const char* what, const std::string& word = {}) {
    capture_.set(property, value);
    const double got = capture_.get(property);
    if (std::abs(got - value) < 0.5) return;
    throw InputError(
        fmt::format("{} has no {} {}", address_, what,
                    word.empty() ? fmt::format("{:g}", value) : word),
        fmt::format("`v4l2-ctl -d {} --list-formats-ext` (package v4l-utils) says what it has",
                    address_));
  }
  std::string set(int property, double value, const std::string& what) {
    return capture_.set(property, value) ? "" : address_ + " does not take " + what;
  }

  std::string address_, name_;
  cv::VideoCapture capture_;
  double rate_ = 0;
};

/// A video file or a sequence of images, played at its rate; or a stream, as it comes.
class FileSource : public FrameSource {
 public:
  explicit FileSource(const VideoOptions& options)
      : address_(options.address), start_(options.start) {
    is_stream_ = address_.find("://") != std::string::npos;
    const bool is_sequence = address_.find('%') != std::string::npos;
    std::error_code error;
    if (!is_stream_ && !is_sequence && !std::filesystem::is_regular_file(address_, error)) {
      throw InputError("there is no video " + address_,
                       "Name a device as /dev/video0, a video, a sequence of images as "
                       "left_%04d.png, or a stream as rtsp://HOST/PATH");
    }
    if (options.width > 0 || options.height > 0 || !options.format.empty() ||
        (options.rate > 0 && is_stream_)) {
      throw InputError(address_ + " is no device that could be asked for a size, rate or format",
                       "Leave width, height, format and rate away");
    }
    open();
    const double said = is_sequence ? 0 : capture_.get(cv::CAP_PROP_FPS);
    const bool makes_sense = std::isfinite(said) && said > 0 && said < 1000;
    rate_ = options.rate > 0 ? options.rate : makes_sense ? said : is_stream_ ? 0 : kDefaultRate;
    name_ = fmt::format("{}: {:.0f} x {:.0f}, {:.3g}/s", address_,
                        capture_.get(cv::CAP_PROP_FRAME_WIDTH),
                        capture_.get(cv::CAP_PROP_FRAME_HEIGHT), rate_);
  }

  std::optional<Frame> next(Time patience) override {
    if (is_at_end_) {
      std::this_thread::sleep_for(patience);
      return std::nullopt;
    }
    if (!is_stream_) {
      const Time due = start_ + to_time(static_cast<double>(count_) / rate_);
      const Time now = steady_now();
      if (due > now) {
        std::this_thread::sleep_for(std::min(due - now, patience));
        if (due - now > patience) return std::nullopt;
      }
    }
    cv::Mat image;
    if (!capture_.read(image)) {
      if (is_stream_) throw SourceLost(address_ + " gives no more frames");
      if (count_ == 0) throw SourceLost(address_ + " has no frame that can be decoded");
      is_at_end_ = true;
      return std::nullopt;
    }
    Frame frame;
    frame.image = color_image(image, address_);
    frame.stamp = is_stream_ ? steady_now() : start_ + to_time(static_cast<double>(count_) / rate_);
    ++count_;
    return frame;
  }
  bool is_at_end() const override { return is_at_end_; }
  bool rewind(Time start) override {
    if (is_stream_) return false;
    open();
    start_ = start;
    count_ = 0;
    is_at_end_ = false;
    return true;
  }
  double rate() const override { return rate_; }
  const std::string& name() const override { return name_; }
  std::string set_exposure(double) override { return address_ + " was exposed already"; }
  std::string set_gain(double) override { return address_ + " has no gain"; }

 private:
  void open() {
    capture_.release();
    bool is_open = false;
    try {
      is_open = capture_.open(address_);
    } catch (const cv::Exception&) {  // of patterns without a first image
    }
    if (!is_open) {
      throw InputError(address_ + " cannot be read as a video",
                       is_stream_ ? "Check the address, and that the sender runs"
                                  : "It may be damaged, or its format be unknown to OpenCV; of a "
                                    "sequence the first image may be missing");
    }
  }

  std::string address_, name_;
  cv::VideoCapture capture_;
  Time start_{};
  double rate_ = 0;
  std::uint64_t count_ = 0;
  bool is_stream_ = false;
  bool is_at_end_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> open_video_source(const VideoOptions& options) {
  // What OpenCV would print is said by errors here, once.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  if (options.address.empty()) {
    throw InputError("no camera is named", "Give /dev/video0, a video, or a stream");
  }
  if (!options.format.empty() && options.format.size() != 4) {
    throw InputError("the format '" + options.format + "' is not four letters",
                     "Write MJPG, YUYV ...");
  }
  if (is_device_address(options.address)) return std::make_unique<DeviceSource>(options);
  return std::make_unique<FileSource>(options);
}

}  // namespace prehend::drivers::camera
