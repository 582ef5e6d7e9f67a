#include "msgs/ros/camera_pairing.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <google/protobuf/message.h>

#include "msgs/camera.pb.h"
#include "msgs/ros/from_ros.h"
#include "msgs/sensors.pb.h"

namespace prehend::ros {
namespace {

constexpr std::int64_t kSameInstant = 2'000'000;  // ns between the images of a pair
constexpr std::int64_t kSameView = 50'000'000;    // ns between depth and its colours

/// Where image_transport and the drivers put the calibration of an image's camera.
std::string info_topic_of(std::string image) {
  for (const char* ending : {"/compressed", "/compressedDepth"}) {
    const std::string end = ending;
    if (image.size() > end.size() &&
        image.compare(image.size() - end.size(), end.size(), end) == 0) {
      image.erase(image.size() - end.size());
      break;
    }
  }
  return image.substr(0, image.rfind('/') + 1) + "camera_info";
}

/// Image and CameraInfo of one camera, the newest.
struct Camera {
  explicit Camera(const std::string& topic)
      : image_topic(topic), info_topic(info_topic_of(topic)) {}
  std::string image_topic, info_topic;
  std::optional<msgs::Image> image;
  std::optional<msgs::CameraInfo> info;
};

void require(bool came, const std::string& what) {
  if (!came) throw std::runtime_error(what);
}

class StereoPairing : public CameraPairing {
 public:
  StereoPairing(const std::string& left, const std::string& right) : left_(left), right_(right) {}
  std::vector<std::string> pictures() const override {
    return {left_.image_topic, right_.image_topic};
  }
  std::vector<std::string> calibrations() const override {
    return {left_.info_topic, right_.info_topic};
  }
  void take(const std::string& topic, std::uint64_t time, const google::protobuf::Message& message,
            const Write& write) override {
    for (Camera* camera : {&left_, &right_}) {
      if (topic == camera->info_topic) take_info(*camera, message);
      if (topic == camera->image_topic) take_image(*camera, message);
    }
    if (!told_info_ && left_.info && right_.info) {
      msgs::CameraInfo info = *left_.info;
      info.set_baseline(right_.info->baseline());
      require(info.baseline() > 0, right_.info_topic +
                                       " has no baseline (P[3] is 0): the pair is not "
                                       "calibrated as one");
      write("/camera/info", time, info);
      told_info_ = true;
    }
    if (!left_.image || !right_.image) return;
    const std::int64_t apart = left_.image->header().stamp() - right_.image->header().stamp();
    if (std::abs(apart) > kSameInstant) {
      (apart < 0 ? left_ : right_).image.reset();  // its partner is missing
      ++single_;
      return;
    }
    write("/camera/stereo", time, stereo_pair(*left_.image, *right_.image));
    left_.image.reset();
    right_.image.reset();
    ++pairs_;
  }
  std::string finish(const Write&) override {
    require(pairs_ > 0, fmt::format("there is no pair of {} and {} whose stamps agree within 2 ms",
                                    left_.image_topic, right_.image_topic));
    require(told_info_, fmt::format("the calibration is missing: {} and {}", left_.info_topic,
                                    right_.info_topic));
    single_ += left_.image.has_value() + right_.image.has_value();
    return single_ > 0 ? fmt::format("{} images without a partner were left out", single_) : "";
  }

 private:
  static void take_info(Camera& camera, const google::protobuf::Message& message) {
    if (const auto* info = dynamic_cast<const msgs::CameraInfo*>(&message)) camera.info = *info;
  }
  void take_image(Camera& camera, const google::protobuf::Message& message) {
    const auto* image = dynamic_cast<const msgs::Image*>(&message);
    require(image != nullptr, camera.image_topic + " has no images of 8 bit");
    single_ += camera.image.has_value();  // the one before has no partner
    camera.image = *image;
  }

  Camera left_, right_;
  bool told_info_ = false;
  int pairs_ = 0, single_ = 0;
};

class DepthPairing : public CameraPairing {
 public:
  DepthPairing(const std::string& depth, std::string color)
      : depth_(depth), color_topic_(std::move(color)) {}
  std::vector<std::string> pictures() const override {
    if (color_topic_.empty()) return {depth_.image_topic};
    return {depth_.image_topic, color_topic_};
  }
  std::vector<std::string> calibrations() const override { return {depth_.info_topic}; }
  void take(const std::string& topic, std::uint64_t time, const google::protobuf::Message& message,
            const Write& write) override {
    if (topic == color_topic_) {
      const auto* image = dynamic_cast<const msgs::Image*>(&message);
      require(image != nullptr, color_topic_ + " has no images of 8 bit");
      take_color(*image, write);
    }
    if (topic == depth_.info_topic && !told_info_) {
      write("/camera/info", time, message);
      told_info_ = true;
    }
    if (topic != depth_.image_topic) return;
    const auto* depth = dynamic_cast<const msgs::DepthImage*>(&message);
    require(depth != nullptr, depth_.image_topic + " has no depth (16UC1 or 32FC1)");
    if (waiting_) tell(write);
    waiting_ = *depth;
    waiting_time_ = time;
    // Nearer colours than the newest may come after it.
    if (color_topic_.empty() || apart(color_, *waiting_) <= kSameInstant) tell(write);
  }
  std::string finish(const Write& write) override {
    if (waiting_) tell(write);
    require(images_ > 0, "there is no image on " + depth_.image_topic);
    require(told_info_, "the calibration is missing: " + depth_.info_topic);
    if (color_topic_.empty()) return {};
    require(color_.has_value(), "there is no image on " + color_topic_);
    return fmt::format("{} of {} depth images have colours", colored_, images_);
  }

 private:
  /// [ns] Between two stamps; without a colour more than any.
  static std::int64_t apart(const std::optional<msgs::Image>& color,
                            const msgs::DepthImage& depth) {
    if (!color) return std::numeric_limits<std::int64_t>::max();
    return std::abs(color->header().stamp() - depth.header().stamp());
  }
  void take_color(const msgs::Image& image, const Write& write) {
    std::optional<msgs::Image> before = std::exchange(color_, image);
    if (!waiting_) return;
    const bool is_last = image.header().stamp() >= waiting_->header().stamp();
    if (apart(before, *waiting_) < apart(color_, *waiting_)) std::swap(color_, before);
    if (is_last) {
      tell(write);
      color_ = image;
    }
  }
  void tell(const Write& write) {
    const bool is_colored = apart(color_, *waiting_) <= kSameView;
    write("/camera/depth", waiting_time_, is_colored ? colored(*waiting_, *color_) : *waiting_);
    ++images_;
    colored_ += is_colored;
    waiting_.reset();
  }

  const Camera depth_;
  const std::string color_topic_;
  std::optional<msgs::Image> color_;
  std::optional<msgs::DepthImage> waiting_;  // for its colours
  std::uint64_t waiting_time_ = 0;
  bool told_info_ = false;
  int images_ = 0, colored_ = 0;
};

}  // namespace

bool CameraPairing::needs(const std::string& topic) const {
  for (const auto& topics : {pictures(), calibrations()}) {
    if (std::find(topics.begin(), topics.end(), topic) != topics.end()) return true;
  }
  return false;
}

std::unique_ptr<CameraPairing> pair_stereo(const std::string& left, const std::string& right) {
  return std::make_unique<StereoPairing>(left, right);
}

std::unique_ptr<CameraPairing> pair_depth(const std::string& depth, const std::string& color) {
  return std::make_unique<DepthPairing>(depth, color);
}

}  // namespace prehend::ros
