// A driver of OpenNI2 (Driver/OniDriverAPI.h of libopenni2-dev): a device prehend://HOST:PORT whose
// pictures come from depth_camera_emulator. OpenNI2 loads it as any other of its drivers, so that
// what uses the library cannot tell the emulated camera from a real one. It is compiled without the
// rest of prehend, whose libraries are not for shared objects.

#include <new>
#define XN_NEW(type, ...) new (std::nothrow) type(__VA_ARGS__)  // of OpenNI's own headers
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/camera/codec/depth_wire.h"
#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers::camera {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr const char* kScheme = "prehend://";
constexpr int kRate = 30;                  // frames/s
constexpr auto kAnswerTime = 2s;           // then the camera counts as unplugged
constexpr double kSensorDistance = 0.025;  // m, of the depth sensor left of the colour camera
constexpr double kMostDepth = 10;          // m

std::string tcp_address(const std::string& uri) {
  return "tcp://" + uri.substr(std::strlen(kScheme));
}

/// The line to the emulator. For one thread.
class Line {
 public:
  explicit Line(const std::string& uri) : stream_(open_byte_stream(tcp_address(uri), 0, 1s)) {}

  /// The newest picture, when it is another than `known`; `lost` when the line or its sense is.
  std::optional<DepthPicture> ask(std::uint32_t known, bool& lost) {
    lost = true;
    if (stream_->write(encode_question(known), kAnswerTime).status != IoStatus::kOk) return {};
    std::array<std::uint8_t, kAnswerHeaderSize> header;
    if (!read(header)) return {};
    std::optional<DepthPicture> picture = decode_answer_header(header);
    if (!picture) return {};
    if (picture->width == 0) {
      lost = false;
      return {};
    }
    std::vector<std::uint8_t> bytes(picture_size(*picture));
    if (!read(bytes)) return {};
    decode_picture(bytes, *picture);
    lost = false;
    return picture;
  }

 private:
  bool read(std::span<std::uint8_t> buffer) {
    const auto end = steady_clock::now() + kAnswerTime;
    while (!buffer.empty()) {
      const IoResult result = stream_->read(buffer, 100ms);
      if (result.status == IoStatus::kClosed || steady_clock::now() > end) return false;
      buffer = buffer.subspan(result.count);
    }
    return true;
  }

  std::unique_ptr<ByteStream> stream_;
};

template <class Value>
OniStatus give(const Value& value, void* data, int* size) {
  if (data == nullptr || size == nullptr || *size < static_cast<int>(sizeof value)) {
    return ONI_STATUS_BAD_PARAMETER;
  }
  std::memcpy(data, &value, sizeof value);
  *size = sizeof value;
  return ONI_STATUS_OK;
}

template <class Value>
OniStatus take(Value& value, const void* data, int size) {
  if (data == nullptr || size != static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(&value, data, sizeof value);
  return ONI_STATUS_OK;
}

class Stream : public oni::driver::StreamBase {
 public:
  Stream(OniSensorType sensor, const DepthPicture& first)
      : sensor_(sensor), fx_(first.fx), fy_(first.fy) {
    mode_ = {sensor == ONI_SENSOR_DEPTH ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888,
             first.width, first.height, kRate};
  }

  OniStatus start() override {
    is_started_ = true;
    return ONI_STATUS_OK;
  }
  void stop() override {
    is_started_ = false;
    const std::lock_guard lock(sending_);  // after this no frame is on its way
  }

  OniBool isPropertySupported(int id) override {
    static constexpr int kAll[] = {ONI_STREAM_PROPERTY_HORIZONTAL_FOV,
                                   ONI_STREAM_PROPERTY_VERTICAL_FOV, ONI_STREAM_PROPERTY_VIDEO_MODE,
                                   ONI_STREAM_PROPERTY_MIRRORING};
    const bool is_depths = sensor_ == ONI_SENSOR_DEPTH && (id == ONI_STREAM_PROPERTY_MAX_VALUE ||
                                                           id == ONI_STREAM_PROPERTY_MIN_VALUE);
    const bool is_colors = sensor_ == ONI_SENSOR_COLOR && control(id) != nullptr;
    return std::find(std::begin(kAll), std::end(kAll), id) != std::end(kAll) || is_depths ||
           is_colors;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    const std::lock_guard lock(mutex_);
    switch (id) {
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
        return give(static_cast<float>(2 * std::atan(mode_.resolutionX / (2 * fx_))), data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV:
        return give(static_cast<float>(2 * std::atan(mode_.resolutionY / (2 * fy_))), data, size);
      case ONI_STREAM_PROPERTY_VIDEO_MODE:
        return give(mode_, data, size);
      case ONI_STREAM_PROPERTY_MIRRORING:
        return give(OniBool{FALSE}, data, size);
      case ONI_STREAM_PROPERTY_STRIDE:
        return give(bytes_per_pixel() * mode_.resolutionX, data, size);
      case ONI_STREAM_PROPERTY_CROPPING:  // recordings without it give no frames
        return give(OniCropping{FALSE, 0, 0, mode_.resolutionX, mode_.resolutionY}, data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE:
        return give(static_cast<int>(most_count()), data, size);
      case ONI_STREAM_PROPERTY_MIN_VALUE:
        return give(0, data, size);
      default: {
        const int* value = sensor_ == ONI_SENSOR_COLOR ? control(id) : nullptr;
        return value ? give(*value, data, size) : ONI_STATUS_NOT_SUPPORTED;
      }
    }
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    const std::lock_guard lock(mutex_);
    if (int* value = sensor_ == ONI_SENSOR_COLOR ? control(id) : nullptr) {
      return take(*value, data, size);
    }
    if (id == ONI_STREAM_PROPERTY_MIRRORING) {
      OniBool mirrors = FALSE;
      const OniStatus status = take(mirrors, data, size);
      return status == ONI_STATUS_OK && mirrors ? ONI_STATUS_NOT_SUPPORTED : status;
    }
    if (id != ONI_STREAM_PROPERTY_VIDEO_MODE) return ONI_STATUS_NOT_SUPPORTED;
    OniVideoMode wanted;
    const OniStatus status = take(wanted, data, size);
    if (status != ONI_STATUS_OK) return status;
    const bool is_format = sensor_ == ONI_SENSOR_DEPTH
                               ? wanted.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM ||
                                     wanted.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM
                               : wanted.pixelFormat == ONI_PIXEL_FORMAT_RGB888;
    if (!is_format || wanted.resolutionX != mode_.resolutionX ||
        wanted.resolutionY != mode_.resolutionY || wanted.fps != kRate) {
      return ONI_STATUS_BAD_PARAMETER;
    }
    mode_ = wanted;
    return ONI_STATUS_OK;
  }

  // By the device's thread.
  void send(const DepthPicture& picture, const std::vector<std::uint16_t>& depth, int index,
            std::uint64_t stamp) {
    const std::lock_guard sending(sending_);
    if (!is_started_) return;
    OniVideoMode mode;
    {
      const std::lock_guard lock(mutex_);
      if (picture.width != mode_.resolutionX || picture.height != mode_.resolutionY) return;
      mode = mode_;
    }
    OniFrame* frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    const int pixel = bytes_per_pixel();
    const int size = pixel * mode.resolutionX * mode.resolutionY;
    if (frame->dataSize < size) {
      getServices().releaseFrame(frame);
      return;
    }
    if (sensor_ == ONI_SENSOR_DEPTH) {
      auto* to = static_cast<std::uint16_t*>(frame->data);
      const bool is_fine = mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM;
      std::transform(depth.begin(), depth.end(), to, [is_fine](std::uint16_t count) {
        return is_fine ? count : static_cast<std::uint16_t>((count + 5) / 10);
      });
    } else {
      std::memcpy(frame->data, picture.color.data(), static_cast<std::size_t>(size));
    }
    frame->dataSize = size;
    frame->sensorType = sensor_;
    frame->timestamp = stamp;
    frame->frameIndex = index;
    frame->width = mode.resolutionX;
    frame->height = mode.resolutionY;
    frame->videoMode = mode;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->stride = pixel * mode.resolutionX;
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

 private:
  int bytes_per_pixel() const { return sensor_ == ONI_SENSOR_DEPTH ? 2 : 3; }
  double most_count() const {
    return mode_.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM ? 65535 : kMostDepth * 1e3;
  }

  // Exposure and its like, kept as a camera does; the simulated images are lit as they are.
  int* control(int id) {
    switch (id) {
      case ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE:
        return &auto_white_balance_;
      case ONI_STREAM_PROPERTY_AUTO_EXPOSURE:
        return &auto_exposure_;
      case ONI_STREAM_PROPERTY_EXPOSURE:
        return &exposure_;
      case ONI_STREAM_PROPERTY_GAIN:
        return &gain_;
      default:
        return nullptr;
    }
  }

  OniSensorType sensor_;
  double fx_, fy_;
  int auto_white_balance_ = TRUE, auto_exposure_ = TRUE, exposure_ = 10, gain_ = 100;
  std::mutex mutex_;    // guards mode_
  std::mutex sending_;  // held while a frame is handed over
  OniVideoMode mode_{};
  std::atomic<bool> is_started_ = false;
};

class Device : public oni::driver::DeviceBase {
 public:
  /// Connects and waits for a picture. @throws std::runtime_error
  Device(const std::string& uri, std::function<void()> lost) : line_(uri), lost_(std::move(lost)) {
    const auto end = steady_clock::now() + kAnswerTime;
    bool is_lost = false;
    while (picture_.width == 0 && !is_lost && steady_clock::now() < end) {
      if (auto picture = line_.ask(0, is_lost)) picture_ = std::move(*picture);
      if (picture_.width == 0) std::this_thread::sleep_for(20ms);
    }
    if (picture_.width == 0) throw std::runtime_error("the emulated camera has no picture");
    const auto mode = [&](OniPixelFormat format) {
      return OniVideoMode{format, picture_.width, picture_.height, kRate};
    };
    depth_modes_ = {mode(ONI_PIXEL_FORMAT_DEPTH_1_MM), mode(ONI_PIXEL_FORMAT_DEPTH_100_UM)};
    color_modes_ = {mode(ONI_PIXEL_FORMAT_RGB888)};
    sensors_[0] = {ONI_SENSOR_DEPTH, static_cast<int>(depth_modes_.size()), depth_modes_.data()};
    sensors_[1] = {ONI_SENSOR_COLOR, static_cast<int>(color_modes_.size()), color_modes_.data()};
    thread_ = std::thread([this] { run(); });
  }
  ~Device() override {
    ends_ = true;
    thread_.join();
  }

  OniStatus getSensorInfoList(OniSensorInfo** infos, int* count) override {
    *infos = sensors_.data();
    *count = static_cast<int>(sensors_.size());
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override {
    if (sensor != ONI_SENSOR_DEPTH && sensor != ONI_SENSOR_COLOR) return nullptr;
    const std::lock_guard lock(mutex_);
    streams_.push_back(std::make_unique<Stream>(sensor, picture_));
    return streams_.back().get();
  }
  void destroyStream(oni::driver::StreamBase* stream) override {
    static_cast<Stream*>(stream)->stop();
    const std::lock_guard lock(mutex_);
    std::erase_if(streams_, [&](const auto& one) { return one.get() == stream; });
  }

  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    return give(is_registered_ ? ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR : ONI_IMAGE_REGISTRATION_OFF,
                data, size);
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    OniImageRegistrationMode mode;
    const OniStatus status = take(mode, data, size);
    if (status == ONI_STATUS_OK) is_registered_ = mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    return status;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
    return mode == ONI_IMAGE_REGISTRATION_OFF || mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  }

 private:
  void run() {
    const auto begin = steady_clock::now();
    auto next = begin;
    std::vector<std::uint16_t> unregistered = depth_from_the_left(picture_, kSensorDistance);
    for (int index = 1; !ends_; ++index) {
      next += std::chrono::microseconds(1'000'000 / kRate);
      std::this_thread::sleep_until(next);
      bool is_lost = false;
      if (auto newer = line_.ask(picture_.number, is_lost)) {
        unregistered = depth_from_the_left(*newer, kSensorDistance);
        const std::lock_guard lock(mutex_);
        picture_ = std::move(*newer);
      }
      if (is_lost) {
        if (!ends_) lost_();
        return;
      }
      const auto stamp = static_cast<std::uint64_t>(
          std::chrono::duration_cast<std::chrono::microseconds>(steady_clock::now() - begin)
              .count());
      const std::lock_guard lock(mutex_);
      for (const auto& stream : streams_) {
        stream->send(picture_, is_registered_ ? picture_.depth : unregistered, index, stamp);
      }
    }
  }

  Line line_;
  std::function<void()> lost_;
  DepthPicture picture_;
  std::vector<OniVideoMode> depth_modes_, color_modes_;
  std::array<OniSensorInfo, 2> sensors_{};
  std::mutex mutex_;  // guards streams_, and picture_ where another thread reads it
  std::vector<std::unique_ptr<Stream>> streams_;
  std::atomic<bool> is_registered_ = false;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

class Driver : public oni::driver::DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus tryDevice(const char* uri) override {
    const std::string address = uri;
    OniDeviceInfo info{};
    if (!address.starts_with(kScheme) || address.size() >= sizeof info.uri) return ONI_STATUS_ERROR;
    try {
      Line line(address);  // somebody is there
    } catch (const std::exception& error) {
      getServices().errorLoggerAppend("%s\n", error.what());
      return ONI_STATUS_NO_DEVICE;
    }
    deviceConnected(&describe(info, address));
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char* /*mode*/) override {
    const std::string address = uri;
    try {
      return new Device(address, [this, address] {
        OniDeviceInfo info{};
        deviceDisconnected(&describe(info, address));
      });
    } catch (const std::exception& error) {
      getServices().errorLoggerAppend("%s\n", error.what());
      OniDeviceInfo info{};
      deviceDisconnected(&describe(info, address));  // tried anew when it is opened next
      return nullptr;
    }
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}

 private:
  static const OniDeviceInfo& describe(OniDeviceInfo& info, const std::string& uri) {
    const auto copy = [](char(&to)[ONI_MAX_STR], const std::string& from) {
      from.copy(to, sizeof to - 1);
    };
    copy(info.uri, uri);
    copy(info.vendor, "prehend");
    copy(info.name, "simulated depth camera");
    return info;
  }
};

}  // namespace
}  // namespace prehend::drivers::camera

using PrehendDriver = prehend::drivers::camera::Driver;
ONI_EXPORT_DRIVER(PrehendDriver)
