#include <fmt/format.h>
#include <fmt/ranges.h>

#include <OpenNI.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <mutex>
#include <numbers>
#include <thread>
#include <utility>

#include "drivers/camera/transport/depth_source.h"
#include "drivers/camera/transport/device_clock.h"
#include "drivers/camera/transport/frame_pairing.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers::camera {
namespace {

using geometry::InputError;

// OpenNI's own words on what went wrong last: lines, of which the first says it.
std::string openni_words() {
  std::string words = openni::OpenNI::getExtendedError();
  std::replace(words.begin(), words.end(), '\t', ' ');
  const auto first = words.find_first_not_of(" \n");
  if (first == std::string::npos) return "it does not say why";
  words = words.substr(first, words.find('\n', first) - first);
  while (words.ends_with('.') || words.ends_with(' ')) words.pop_back();
  return words;
}

/// OpenNI2 is started once in a process, and counts who uses it.
class Library {
 public:
  Library() {
    const std::lock_guard lock(mutex());
    if (openni::OpenNI::initialize() != openni::STATUS_OK) {
      const std::string words = openni_words();
      openni::OpenNI::shutdown();
      throw InputError("OpenNI2 cannot start: " + words,
                       "Its drivers are in the folder OpenNI2/Drivers beside libOpenNI2.so.0 "
                       "(package libopenni2-0)");
    }
  }
  ~Library() {
    const std::lock_guard lock(mutex());
    openni::OpenNI::shutdown();
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  static std::vector<std::string> devices() {
    openni::Array<openni::DeviceInfo> list;
    openni::OpenNI::enumerateDevices(&list);
    std::vector<std::string> all;
    for (int i = 0; i < list.getSize(); ++i) {
      all.push_back(
          fmt::format("{} ({} {})", list[i].getUri(), list[i].getVendor(), list[i].getName()));
    }
    return all;
  }

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
};

class OpenniSource : public DepthSource,
                     private openni::OpenNI::DeviceDisconnectedListener,
                     private openni::OpenNI::DeviceStateChangedListener {
 public:
  explicit OpenniSource(const OpenniOptions& options) : options_(options) {
    open_device();
    try {
      open_streams();
    } catch (...) {  // whatever it is goes on, when the device is closed
      close();
      throw;
    }
    openni::OpenNI::addDeviceDisconnectedListener(this);
    openni::OpenNI::addDeviceStateChangedListener(this);
  }
  ~OpenniSource() override {
    openni::OpenNI::removeDeviceDisconnectedListener(this);
    openni::OpenNI::removeDeviceStateChangedListener(this);
    close();
  }

  std::optional<DepthView> next(Time patience, const IsWanted& is_wanted) override {
    if (is_gone_) throw SourceLost(name_ + " was unplugged");
    if (at_end_) return std::nullopt;
    std::array<openni::VideoStream*, 2> streams{&depth_, &color_};
    int ready = -1;
    const auto wait = std::max<std::int64_t>(
        1, std::chrono::duration_cast<std::chrono::milliseconds>(patience).count());
    const openni::Status status = openni::OpenNI::waitForAnyStream(
        streams.data(), color_.isValid() ? 2 : 1, &ready, static_cast<int>(wait));
    if (status == openni::STATUS_TIME_OUT) return std::nullopt;
    if (status != openni::STATUS_OK) throw SourceLost(name_ + " is lost: " + openni_words());
    openni::VideoFrameRef frame;
    if (streams.at(static_cast<std::size_t>(ready))->readFrame(&frame) != openni::STATUS_OK) {
      throw SourceLost(name_ + " is lost: " + openni_words());
    }
    std::optional<DepthView> view = take(static_cast<std::size_t>(ready), frame, is_wanted);
    note_end(static_cast<std::size_t>(ready), frame);
    return view;
  }
  bool is_at_end() const override { return at_end_; }
  double rate() const override { return rate_; }
  const std::string& name() const override { return name_; }
  const std::string& refused() const override { return refused_; }
  std::uint64_t unpaired() const override {
    return pairing_ ? pairing_->dropped(0) + pairing_->dropped(1) : 0;
  }

 private:
  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    if (uri_ == info->getUri()) is_gone_ = true;
  }
  void onDeviceStateChanged(const openni::DeviceInfo* info, openni::DeviceState state) override {
    if (uri_ == info->getUri() && state == openni::DEVICE_STATE_ERROR) is_gone_ = true;
  }

  void open_device() {
    std::string uri = options_.uri;
    std::error_code error;
    const bool is_recording = uri.ends_with(".oni");
    if (is_recording && !std::filesystem::is_regular_file(uri, error)) {
      throw InputError("there is no recording " + uri, "Check the path");
    }
    if (uri.empty()) {
      const std::vector<std::string> all = Library::devices();
      if (all.empty()) {
        throw InputError("OpenNI2 finds no depth camera",
                         "Look at plug and supply; the rules of package libopenni2-0 "
                         "(60-libopenni2-0.rules) let users open one after it is plugged in anew");
      }
      if (all.size() > 1) {
        throw InputError(fmt::format("OpenNI2 finds {} depth cameras", all.size()),
                         fmt::format("Name one by its URI: {}", fmt::join(all, ", ")));
      }
    }
    const char* any = openni::ANY_DEVICE;
    if (device_.open(uri.empty() ? any : uri.c_str()) != openni::STATUS_OK) {
      const std::string words = openni_words();
      const std::vector<std::string> all = Library::devices();
      throw InputError(
          fmt::format("OpenNI2 cannot open {}: {}", uri.empty() ? "the depth camera" : uri, words),
          is_recording  ? "It may be damaged, or be one of OpenNI 1"
          : all.empty() ? "It finds no depth camera; look at plug, supply and permissions"
                        : fmt::format("There are {}", fmt::join(all, ", ")));
    }
    uri_ = device_.getDeviceInfo().getUri();
    name_ = is_recording ? uri
                         : fmt::format("{} {} ({})", device_.getDeviceInfo().getVendor(),
                                       device_.getDeviceInfo().getName(), uri_);
  }

  void open_streams() {
    if (!device_.hasSensor(openni::SENSOR_DEPTH) ||
        depth_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK) {
      throw InputError(name_ + " has no depth", "Choose a depth camera, or record depth, too");
    }
    if (device_.isFile()) {
      if (options_.width > 0 || options_.height > 0 || options_.rate > 0) {
        throw InputError(name_ + " is a recording, which has the mode it was recorded with",
                         "Leave width, height and rate away");
      }
      openni::PlaybackControl* playback = device_.getPlaybackControl();
      if (playback) playback->setRepeatEnabled(options_.loop);
    } else {
      choose_mode();
    }
    depth_.setMirroringEnabled(false);
    if (options_.color) open_color();
    const openni::VideoMode mode = depth_.getVideoMode();
    rate_ = mode.getFps() > 0 ? mode.getFps() : 30;
    if (depth_.start() != openni::STATUS_OK ||
        (color_.isValid() && color_.start() != openni::STATUS_OK)) {
      throw InputError(name_ + " does not start: " + openni_words(),
                       "Another program may use it; a USB 2 line may be too slow for the mode");
    }
    if (color_.isValid()) {
      // Two of one instant have one stamp, or are a moment apart.
      pairing_.emplace(FramePairing<Image>::half_a_frame(rate_));
    }
    if (!device_.isFile()) set_controls();
  }

  void choose_mode() {
    const openni::VideoMode now = depth_.getVideoMode();
    const auto fits = [&](const openni::VideoMode& mode) {
      const bool is_depth = mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM ||
                            mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM;
      const int width = options_.width > 0 ? options_.width : now.getResolutionX();
      const int height = options_.height > 0 ? options_.height : now.getResolutionY();
      return is_depth && mode.getResolutionX() == width && mode.getResolutionY() == height &&
             (options_.rate == 0 || std::abs(mode.getFps() - options_.rate) < 0.5);
    };
    const auto& modes = depth_.getSensorInfo().getSupportedVideoModes();
    std::optional<openni::VideoMode> chosen;
    std::vector<std::string> known;
    for (int i = 0; i < modes.getSize(); ++i) {
      known.push_back(fmt::format("{} x {} at {}/s", modes[i].getResolutionX(),
                                  modes[i].getResolutionY(), modes[i].getFps()));
      if (!fits(modes[i])) continue;
      // The finer unit, then the mode it is in.
      const bool is_finer = modes[i].getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM &&
                            chosen && chosen->getPixelFormat() != modes[i].getPixelFormat();
      const bool is_current = modes[i].getFps() == now.getFps();
      if (!chosen || is_finer ||
          (is_current && chosen->getFps() != now.getFps() &&
           chosen->getPixelFormat() == modes[i].getPixelFormat())) {
        chosen = modes[i];
      }
    }
    if (!chosen || depth_.setVideoMode(*chosen) != openni::STATUS_OK) {
      throw InputError(name_ + " has no such mode of depth",
                       fmt::format("It has {}", fmt::join(known, ", ")));
    }
  }

  void open_color() {
    if (!device_.hasSensor(openni::SENSOR_COLOR) ||
        color_.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK) {
      throw InputError(name_ + " has no colour", "Leave it away: color:=false");
    }
    const openni::VideoMode depth = depth_.getVideoMode();
    if (!device_.isFile()) {
      const auto& modes = color_.getSensorInfo().getSupportedVideoModes();
      bool is_set = false;
      for (int i = 0; i < modes.getSize() && !is_set; ++i) {
        is_set = modes[i].getPixelFormat() == openni::PIXEL_FORMAT_RGB888 &&
                 modes[i].getResolutionX() == depth.getResolutionX() &&
                 modes[i].getResolutionY() == depth.getResolutionY() &&
                 modes[i].getFps() == depth.getFps() &&
                 color_.setVideoMode(modes[i]) == openni::STATUS_OK;
      }
      if (!is_set) {
        throw InputError(
            fmt::format("{} has no red-green-blue of {} x {} at {}/s beside its depth", name_,
                        depth.getResolutionX(), depth.getResolutionY(), depth.getFps()),
            "Choose another mode, or color:=false");
      }
      const auto registered = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
      if (!device_.isImageRegistrationModeSupported(registered) ||
          device_.setImageRegistrationMode(registered) != openni::STATUS_OK) {
        throw InputError(name_ + " does not register its depth to its colour",
                         "Use the depth alone: color:=false");
      }
      device_.setDepthColorSyncEnabled(true);  // what cannot is paired by stamps all the same
    }
    color_.setMirroringEnabled(false);
  }

  void set_controls() {
    const bool wanted = options_.exposure >= 0 || options_.gain >= 0;
    if (!wanted) return;
    openni::CameraSettings* settings = color_.isValid() ? color_.getCameraSettings() : nullptr;
    const auto add = [&](const std::string& what) {
      refused_ += (refused_.empty() ? name_ + " does not take " : ", ") + what;
    };
    if (!settings) {
      add("exposure and gain (no colour camera, or one that does all by itself)");
      return;
    }
    if (options_.exposure >= 0) {
      const bool own = options_.exposure == 0;
      const bool is_set =
          settings->setAutoExposureEnabled(own) == openni::STATUS_OK &&
          (own || settings->setExposure(static_cast<int>(std::lround(options_.exposure * 1e3))) ==
                      openni::STATUS_OK);
      if (!is_set) add("an exposure");
    }
    if (options_.gain > 0 &&
        settings->setGain(static_cast<int>(std::lround(options_.gain))) != openni::STATUS_OK) {
      add("a gain");
    }
  }

  /// A frame of OpenNI2, which goes on existing for as long as it is held.
  struct Image {
    openni::VideoFrameRef frame;
    Time stamp{};  // by steady_now()
  };

  std::optional<DepthView> take(std::size_t stream, const openni::VideoFrameRef& frame,
                                const IsWanted& is_wanted) {
    const Time device = std::chrono::microseconds(frame.getTimestamp());
    Image image{frame, stream == 0 ? clock_.to_host(device, steady_now()) : Time{}};
    if (!pairing_) return converted(image, nullptr, is_wanted);
    // Paired by the device's own stamps. A recording that begins anew has earlier ones.
    if (device < last_device_stamp_ - to_time(1 / rate_)) pairing_->restart();
    last_device_stamp_ = device;
    const auto pair = pairing_->add(stream, device, std::move(image));
    if (!pair) return std::nullopt;
    return converted(pair->first.item, &pair->second.item, is_wanted);
  }
  DepthView converted(const Image& depth, const Image* color, const IsWanted& is_wanted) {
    DepthView view;
    if (!is_wanted || is_wanted(depth.stamp)) {
      view = depth_view(depth.frame);
      // A recording may have two sizes: the depth is not registered to the colour then.
      const bool fits = color && color->frame.getWidth() == view.depth.width &&
                        color->frame.getHeight() == view.depth.height;
      if (fits) view.color = color_image(color->frame);
    }
    view.stamp = depth.stamp;
    return view;
  }

  // A frame's rows, checked: drivers and damaged recordings fill them in.
  const std::uint8_t* row(const openni::VideoFrameRef& frame, int v, int bytes_per_pixel) const {
    const auto* data = static_cast<const std::uint8_t*>(frame.getData());
    const std::int64_t stride = frame.getStrideInBytes();
    const std::int64_t end = stride * v + std::int64_t{frame.getWidth()} * bytes_per_pixel;
    if (data == nullptr || stride < 0 || end > frame.getDataSize()) {
      throw SourceLost(name_ + " gives damaged frames");
    }
    return data + stride * v;
  }
  void check_size(const openni::VideoFrameRef& frame) const {
    constexpr int kLargest = 16384;
    if (frame.getWidth() <= 0 || frame.getHeight() <= 0 || frame.getWidth() > kLargest ||
        frame.getHeight() > kLargest) {
      throw SourceLost(name_ + " gives damaged frames");
    }
  }

  DepthView depth_view(const openni::VideoFrameRef& frame) {
    check_size(frame);
    const auto format = frame.getVideoMode().getPixelFormat();
    if (format != openni::PIXEL_FORMAT_DEPTH_1_MM && format != openni::PIXEL_FORMAT_DEPTH_100_UM) {
      throw SourceLost(name_ + " gives depth in a format that is no length");
    }
    DepthView view;
    view.unit = format == openni::PIXEL_FORMAT_DEPTH_1_MM ? 1e-3 : 1e-4;
    const int width = frame.getWidth(), height = frame.getHeight();
    view.depth = geometry::DepthImage(width, height, std::numeric_limits<float>::quiet_NaN());
    for (int v = 0; v < height; ++v) {
      const std::uint8_t* from = row(frame, v, 2);
      for (int u = 0; u < width; ++u) {
        std::uint16_t counts;
        std::memcpy(&counts, from + 2 * u, 2);
        if (counts != 0) view.depth.at(u, v) = static_cast<float>(counts * view.unit);
      }
    }
    // OpenNI tells angles of view alone: the principal point is the image's centre, as in its
    // CoordinateConverter (pixel centres at whole numbers there, too).
    const double horizontal = depth_.getHorizontalFieldOfView();
    const double vertical = depth_.getVerticalFieldOfView();
    constexpr double kPi = std::numbers::pi;
    if (!(horizontal > 0 && horizontal < kPi && vertical > 0 && vertical < kPi)) {
      throw SourceLost(name_ + " does not say its angle of view");
    }
    view.camera = {width,
                   height,
                   width / (2 * std::tan(horizontal / 2)),
                   height / (2 * std::tan(vertical / 2)),
                   width / 2.0,
                   height / 2.0};
    return view;
  }

  geometry::ColorImage color_image(const openni::VideoFrameRef& frame) const {
    check_size(frame);
    if (frame.getVideoMode().getPixelFormat() != openni::PIXEL_FORMAT_RGB888) {
      throw SourceLost(name_ + " gives colour that is not red-green-blue");
    }
    geometry::ColorImage image(frame.getWidth(), frame.getHeight());
    for (int v = 0; v < image.height; ++v) {
      std::memcpy(&image.at(0, v), row(frame, v, 3), std::size_t{3} * image.width);
    }
    return image;
  }

  // OpenNI does not tell a recording's end where it does not repeat; the last frames do.
  void note_end(std::size_t stream, const openni::VideoFrameRef& frame) {
    if (!device_.isFile() || options_.loop) return;
    openni::PlaybackControl* playback = device_.getPlaybackControl();
    const int frames = playback ? playback->getNumberOfFrames(stream == 0 ? depth_ : color_) : 0;
    if (frames > 0 && frame.getFrameIndex() >= frames) has_ended_.at(stream) = true;
    at_end_ = has_ended_[0] && (has_ended_[1] || !color_.isValid());
    if (at_end_) stop_streams();  // the player would take a whole processor at its file's end
  }

  void stop_streams() {
    for (openni::VideoStream* stream : {&depth_, &color_}) {
      if (stream->isValid()) stream->stop();
    }
  }
  void close() {
    stop_streams();
    // OpenNI2's player of recordings looks at its streams without a lock, all the time while one is
    // started, else every 10 ms: it must have come to rest before they go.
    if (rate_ > 0 && device_.isFile()) {  // its streams were started
      std::this_thread::sleep_for(to_time(1 / rate_) + std::chrono::milliseconds(50));
    }
    depth_.destroy();
    color_.destroy();
    device_.close();
  }

  Library library_;
  OpenniOptions options_;
  openni::Device device_;
  openni::VideoStream depth_, color_;
  std::optional<FramePairing<Image>> pairing_;  // depth, and colour
  DeviceClock clock_;
  Time last_device_stamp_{};
  std::string uri_, name_, refused_;
  double rate_ = 0;
  std::array<bool, 2> has_ended_{};  // depth, colour
  bool at_end_ = false;
  std::atomic<bool> is_gone_ = false;
};

}  // namespace

std::unique_ptr<DepthSource> open_openni_source(const OpenniOptions& options) {
  return std::make_unique<OpenniSource>(options);
}

std::vector<std::string> openni_devices() {
  const Library library;
  return Library::devices();
}

}  // namespace prehend::drivers::camera
