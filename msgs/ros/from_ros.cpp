#include "msgs/ros/from_ros.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "msgs/convert/camera_images.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/graph.pb.h"
#include "prehend/geometry/errors.h"

namespace prehend::ros {
namespace {

using convert::ColoredDepth;
using convert::from_message;
using convert::StereoImages;
using convert::to_message;
using geometry::InputError;
using recording::RosValue;
using MessagePointer = std::unique_ptr<google::protobuf::Message>;

constexpr double kMillimetre = 1e-3;       // m
constexpr double kTenthMillimetre = 1e-4;  // m, of depths that were floating
constexpr const char* kSender = "Mend the program that recorded it";

void take_header(const RosValue& header, msgs::Header* to) {
  to->set_stamp(ros_stamp(header));
  to->set_frame_id(std::string(header["frame_id"].text()));
}

/// A message's pixels, checked.
struct Pixels {
  int width = 0, height = 0;
  std::size_t step = 0;  // bytes a row
  std::string_view data;
  const char* row(int v) const { return data.data() + static_cast<std::size_t>(v) * step; }
};

Pixels pixels_of(const RosValue& image, std::size_t bytes_per_pixel) {
  constexpr std::int64_t kLongestSide = 16384;
  const std::int64_t width = image["width"].integer(), height = image["height"].integer();
  const std::int64_t step = image["step"].integer();
  const std::string_view data = image["data"].bytes();
  const auto row = static_cast<std::int64_t>(bytes_per_pixel) * width;
  if (width < 1 || height < 1 || width > kLongestSide || height > kLongestSide || step < row ||
      static_cast<std::int64_t>(data.size()) < step * (height - 1) + row) {
    throw InputError("An image of " + std::to_string(width) + "x" + std::to_string(height) +
                         " with rows of " + std::to_string(step) + " bytes has " +
                         std::to_string(data.size()) + " bytes of data",
                     kSender);
  }
  return {static_cast<int>(width), static_cast<int>(height), static_cast<std::size_t>(step), data};
}

bool is_big_endian(const RosValue& message) { return message["is_bigendian"].integer() != 0; }

msgs::Image grey_image(const RosValue& image) {
  const Pixels pixels = pixels_of(image, 1);
  msgs::Image message;
  message.set_width(static_cast<std::uint32_t>(pixels.width));
  message.set_height(static_cast<std::uint32_t>(pixels.height));
  message.set_channels(1);
  for (int v = 0; v < pixels.height; ++v) {
    message.mutable_data()->append(pixels.row(v), static_cast<std::size_t>(pixels.width));
  }
  return message;
}

/// @param red, green, blue  bytes of a pixel of `size` bytes
msgs::Image color_image(const RosValue& image, std::size_t size, std::array<int, 3> channels) {
  const Pixels pixels = pixels_of(image, size);
  geometry::ColorImage color(pixels.width, pixels.height);
  auto* to = color.data.data();
  for (int v = 0; v < pixels.height; ++v) {
    const char* from = pixels.row(v);
    for (int u = 0; u < pixels.width; ++u, from += size, ++to) {
      for (std::size_t k = 0; k < 3; ++k) {
        (*to)[k] = static_cast<std::uint8_t>(from[channels[k]]);
      }
    }
  }
  return to_message(color);
}

msgs::DepthImage counted_depth(const cv::Mat& counts) {
  msgs::DepthImage message;
  message.set_width(static_cast<std::uint32_t>(counts.cols));
  message.set_height(static_cast<std::uint32_t>(counts.rows));
  message.set_unit(kMillimetre);
  for (int v = 0; v < counts.rows; ++v) {
    message.mutable_data()->append(reinterpret_cast<const char*>(counts.ptr(v)),
                                   2 * static_cast<std::size_t>(counts.cols));
  }
  return message;
}

msgs::DepthImage millimetres(const RosValue& image) {
  const Pixels pixels = pixels_of(image, 2);
  cv::Mat counts(pixels.height, pixels.width, CV_16U);
  for (int v = 0; v < pixels.height; ++v) {
    std::memcpy(counts.ptr(v), pixels.row(v), 2 * static_cast<std::size_t>(pixels.width));
  }
  return counted_depth(counts);
}

msgs::DepthImage metres(const RosValue& image) {
  const Pixels pixels = pixels_of(image, 4);
  ColoredDepth seen;
  seen.depth =
      geometry::DepthImage(pixels.width, pixels.height, std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < pixels.height; ++v) {
    std::memcpy(
        &seen.depth.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(pixels.width)],
        pixels.row(v), 4 * static_cast<std::size_t>(pixels.width));
  }
  return to_message(seen, kTenthMillimetre);
}

MessagePointer owned(msgs::Image image, const RosValue& from) {
  take_header(from["header"], image.mutable_header());
  return std::make_unique<msgs::Image>(std::move(image));
}
MessagePointer owned(msgs::DepthImage image, const RosValue& from) {
  take_header(from["header"], image.mutable_header());
  return std::make_unique<msgs::DepthImage>(std::move(image));
}

MessagePointer image_from(const RosValue& message) {
  const std::string_view encoding = message["encoding"].text();
  const bool is_wide = encoding == "16UC1" || encoding == "mono16" || encoding == "32FC1";
  if (is_wide && is_big_endian(message)) {
    throw InputError("An image of encoding " + std::string(encoding) + " is big-endian", kSender);
  }
  if (encoding == "16UC1" || encoding == "mono16") return owned(millimetres(message), message);
  if (encoding == "32FC1") return owned(metres(message), message);
  if (encoding == "mono8" || encoding == "8UC1") return owned(grey_image(message), message);
  if (encoding == "rgb8") return owned(color_image(message, 3, {0, 1, 2}), message);
  if (encoding == "bgr8" || encoding == "8UC3") {
    return owned(color_image(message, 3, {2, 1, 0}), message);
  }
  if (encoding == "rgba8") return owned(color_image(message, 4, {0, 1, 2}), message);
  if (encoding == "bgra8" || encoding == "8UC4") {
    return owned(color_image(message, 4, {2, 1, 0}), message);
  }
  throw InputError("Images of encoding '" + std::string(encoding) + "' are not read",
                   "Record mono8, rgb8, bgr8, rgba8, bgra8, 16UC1 or 32FC1 (image_proc makes "
                   "them of others)");
}

cv::Mat decoded(std::string_view bytes, int flags) {
  cv::Mat image;
  if (!bytes.empty()) {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U,
                         const_cast<char*>(bytes.data()));  // NOLINT: is only read
    try {
      image = cv::imdecode(buffer, flags);
    } catch (const cv::Exception&) {
      image.release();
    }
  }
  if (image.empty()) throw InputError("A compressed image is damaged", kSender);
  return image;
}

MessagePointer compressed_from(const RosValue& message) {
  const std::string_view format = message["format"].text();
  std::string_view data = message["data"].bytes();
  if (format.find("compressedDepth") != std::string_view::npos) {
    constexpr std::size_t kHeader = 12;  // of compressed_depth_image_transport
    if (format.find("16UC1") == std::string_view::npos || data.size() <= kHeader) {
      throw InputError("Compressed depth of format '" + std::string(format) + "' is not read",
                       "Record depth as 16UC1, compressed as PNG");
    }
    const cv::Mat counts = decoded(data.substr(kHeader), cv::IMREAD_UNCHANGED);
    if (counts.type() != CV_16UC1)
      throw InputError("A compressed depth is no PNG of 16 bit", kSender);
    return owned(counted_depth(counts), message);
  }
  const cv::Mat image = decoded(data, cv::IMREAD_UNCHANGED);
  if (image.type() == CV_16UC1) return owned(counted_depth(image), message);
  cv::Mat rgb;
  if (image.type() == CV_8UC3) cv::cvtColor(image, rgb, cv::COLOR_BGR2RGB);
  if (image.type() == CV_8UC4) cv::cvtColor(image, rgb, cv::COLOR_BGRA2RGB);
  if (image.type() == CV_8UC1) cv::cvtColor(image, rgb, cv::COLOR_GRAY2RGB);
  if (rgb.empty()) throw InputError("A compressed image is none of 8 bit", kSender);
  geometry::ColorImage color(rgb.cols, rgb.rows);
  for (int v = 0; v < rgb.rows; ++v) {
    std::memcpy(&color.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(rgb.cols)],
                rgb.ptr(v), 3 * static_cast<std::size_t>(rgb.cols));
  }
  return owned(to_message(color), message);
}

/// Of ROS 1 the matrices are K and P, of ROS 2 k and p.
std::vector<double> matrix(const RosValue& message, const char* capital, const char* small,
                           std::size_t size) {
  std::vector<double> numbers = message[message.has(small) ? small : capital].numbers();
  if (numbers.size() != size) throw InputError("A CameraInfo's matrix is cut short", kSender);
  return numbers;
}

MessagePointer camera_from(const RosValue& message) {
  const std::vector<double> k = matrix(message, "K", "k", 9), p = matrix(message, "P", "p", 12);
  const bool has_projection = p[0] > 0;  // else there is one camera, not rectified
  auto info = std::make_unique<msgs::CameraInfo>();
  take_header(message["header"], info->mutable_header());
  info->set_width(static_cast<std::uint32_t>(message["width"].integer()));
  info->set_height(static_cast<std::uint32_t>(message["height"].integer()));
  info->set_fx(has_projection ? p[0] : k[0]);
  info->set_fy(has_projection ? p[5] : k[4]);
  info->set_cx(has_projection ? p[2] : k[2]);
  info->set_cy(has_projection ? p[6] : k[5]);
  // Of the right camera of a pair: Tx = -fx * baseline (sensor_msgs/CameraInfo).
  if (has_projection) info->set_baseline(std::max(0.0, -p[3] / p[0]));
  if (!(info->fx() > 0 && info->fy() > 0 && std::isfinite(info->fx()) &&
        std::isfinite(info->fy()))) {
    throw InputError("A CameraInfo has no focal length: the camera is not calibrated",
                     "Calibrate the camera and record again");
  }
  return info;
}

/// Where a field of a point is, and its type as of sensor_msgs/PointField.
struct PointField {
  std::size_t offset = 0;
  std::int64_t type = 0;
};

class CloudReader {
 public:
  explicit CloudReader(const RosValue& message) : message_(message) {
    if (is_big_endian(message)) throw InputError("A cloud is big-endian", kSender);
    for (const RosValue& field : message["fields"].list()) {
      fields_[std::string(field["name"].text())] = {
          static_cast<std::size_t>(std::max<std::int64_t>(0, field["offset"].integer())),
          field["datatype"].integer()};
    }
    width_ = message["width"].integer();
    height_ = message["height"].integer();
    point_step_ = message["point_step"].integer();
    row_step_ = message["row_step"].integer();
    data_ = message["data"].bytes();
    constexpr std::int64_t kMostPoints = 1 << 28;
    const bool fits =
        width_ >= 0 && height_ >= 0 && point_step_ > 0 && row_step_ >= 0 && width_ <= kMostPoints &&
        height_ <= kMostPoints && width_ * height_ <= kMostPoints &&
        row_step_ / point_step_ >= width_ &&
        static_cast<std::int64_t>(data_.size()) / std::max<std::int64_t>(row_step_, 1) >=
            (width_ > 0 ? height_ : 0);
    if (!fits) throw InputError("A cloud's sizes do not fit its data", kSender);
  }

  geometry::PointCloud read() const {
    const PointField x = float_field("x"), y = float_field("y"), z = float_field("z");
    const auto rgb = color_field();
    const bool has_normals = fields_.count("normal_x") != 0;
    geometry::PointCloud cloud;
    if (height_ > 1) {
      cloud.width = static_cast<int>(width_);
      cloud.height = static_cast<int>(height_);
    }
    for (std::int64_t v = 0; v < height_; ++v) {
      for (std::int64_t u = 0; u < width_; ++u) {
        const char* at = data_.data() + v * row_step_ + u * point_step_;
        cloud.points.push_back(vector(at, x, y, z));
        if (rgb) {
          // 0xAARRGGBB, little endian, whether it is called a float or a number.
          const auto* c = reinterpret_cast<const std::uint8_t*>(at + rgb->offset);
          cloud.colors.push_back({c[2], c[1], c[0]});
        }
        if (has_normals) {
          cloud.normals.push_back(vector(at, float_field("normal_x"), float_field("normal_y"),
                                         float_field("normal_z")));
        }
      }
    }
    return cloud;
  }

 private:
  static constexpr std::int64_t kFloat32 = 7, kFloat64 = 8, kUint32 = 6;

  PointField float_field(const std::string& name) const {
    const auto found = fields_.find(name);
    if (found == fields_.end()) throw InputError("A cloud has no field '" + name + "'", kSender);
    const PointField field = found->second;
    const std::size_t size = field.type == kFloat64 ? 8 : 4;
    if ((field.type != kFloat32 && field.type != kFloat64) ||
        field.offset + size > static_cast<std::size_t>(point_step_)) {
      throw InputError("A cloud's field '" + name + "' is no number within a point", kSender);
    }
    return field;
  }
  std::optional<PointField> color_field() const {
    for (const char* name : {"rgb", "rgba"}) {
      const auto found = fields_.find(name);
      if (found == fields_.end()) continue;
      const PointField field = found->second;
      if ((field.type == kFloat32 || field.type == kUint32) &&
          field.offset + 4 <= static_cast<std::size_t>(point_step_)) {
        return field;
      }
    }
    return std::nullopt;
  }
  static float number(const char* point, const PointField& field) {
    float single = 0;
    double twice = 0;
    if (field.type == kFloat32) {
      std::memcpy(&single, point + field.offset, sizeof single);
      return single;
    }
    std::memcpy(&twice, point + field.offset, sizeof twice);
    return static_cast<float>(twice);
  }
  static Eigen::Vector3f vector(const char* point, const PointField& x, const PointField& y,
                                const PointField& z) {
    const Eigen::Vector3f p(number(point, x), number(point, y), number(point, z));
    if (p.allFinite()) return p;
    return Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  }

  const RosValue& message_;
  std::map<std::string, PointField> fields_;
  std::int64_t width_ = 0, height_ = 0, point_step_ = 0, row_step_ = 0;
  std::string_view data_;
};

MessagePointer cloud_from(const RosValue& message) {
  return std::make_unique<msgs::PointCloud>(to_message(CloudReader(message).read()));
}

MessagePointer joints_from(const RosValue& message) {
  auto joints = std::make_unique<msgs::JointState>();
  take_header(message["header"], joints->mutable_header());
  for (const RosValue& name : message["name"].list()) {
    joints->add_name(std::string(name.text()));
  }
  const auto take = [&](const char* field, auto* to) {
    const std::vector<double> numbers = message[field].numbers();
    if (!numbers.empty() && numbers.size() != static_cast<std::size_t>(joints->name_size())) {
      throw InputError(std::string("A JointState's ") + field + " is not as long as its names",
                       kSender);
    }
    to->Add(numbers.begin(), numbers.end());
  };
  take("position", joints->mutable_position());
  take("velocity", joints->mutable_velocity());
  take("effort", joints->mutable_effort());
  return joints;
}

void take_vector(const RosValue& vector, msgs::Vector3* to) {
  to->set_x(vector["x"].number());
  to->set_y(vector["y"].number());
  to->set_z(vector["z"].number());
}

MessagePointer wrench_from(const RosValue& message) {
  auto wrench = std::make_unique<msgs::Wrench>();
  take_header(message["header"], wrench->mutable_header());
  take_vector(message["wrench"]["force"], wrench->mutable_wrench()->mutable_force());
  take_vector(message["wrench"]["torque"], wrench->mutable_wrench()->mutable_torque());
  return wrench;
}

MessagePointer clock_from(const RosValue& message) {
  auto clock = std::make_unique<msgs::Clock>();
  clock->set_time(ros_nanoseconds(message["clock"]));
  clock->set_speed(1);  // ROS does not say it
  return clock;
}

MessagePointer log_from(const RosValue& message) {
  const bool one = message.has("header");
  const std::int64_t level = message["level"].integer();
  auto line = std::make_unique<msgs::graph::LogLine>();
  line->set_stamp(one ? ros_stamp(message["header"]) : ros_nanoseconds(message["stamp"]));
  line->set_level(level < (one ? 2 : 20)   ? msgs::graph::DEBUG
                  : level < (one ? 4 : 30) ? msgs::graph::INFO
                  : level < (one ? 8 : 40) ? msgs::graph::WARNING
                                           : msgs::graph::ERROR);
  line->set_node(std::string(message["name"].text()));
  line->set_text(std::string(message["msg"].text()));
  return line;
}

const std::map<std::string, std::function<MessagePointer(const RosValue&)>>& conversions() {
  static const std::map<std::string, std::function<MessagePointer(const RosValue&)>> kAll = {
      {"geometry_msgs/WrenchStamped", wrench_from},
      {"rcl_interfaces/Log", log_from},
      {"rosgraph_msgs/Clock", clock_from},
      {"rosgraph_msgs/Log", log_from},
      {"sensor_msgs/CameraInfo", camera_from},
      {"sensor_msgs/CompressedImage", compressed_from},
      {"sensor_msgs/Image", image_from},
      {"sensor_msgs/JointState", joints_from},
      {"sensor_msgs/PointCloud2", cloud_from}};
  return kAll;
}

void require_same_size(std::uint32_t width, std::uint32_t height, const msgs::Image& other,
                       const char* what) {
  if (other.width() == width && other.height() == height) return;
  throw InputError(std::string(what) + ": one image has " + std::to_string(width) + "x" +
                       std::to_string(height) + " pixels, the other " +
                       std::to_string(other.width()) + "x" + std::to_string(other.height()),
                   "Give images of one size");
}

}  // namespace

const std::vector<std::string>& ros_types() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const auto& [name, convert] : conversions()) names.push_back(name);
    return names;
  }();
  return kNames;
}

MessagePointer from_ros(const std::string& type, const RosValue& message) {
  const auto found = conversions().find(recording::ros_type_name(type));
  return found == conversions().end() ? nullptr : found->second(message);
}

std::int64_t ros_nanoseconds(const RosValue& time) {
  return 1'000'000'000 * time["sec"].integer() + time["nanosec"].integer();
}

std::int64_t ros_stamp(const RosValue& header) { return ros_nanoseconds(header["stamp"]); }

msgs::StereoPair stereo_pair(const msgs::Image& left, const msgs::Image& right) {
  require_same_size(left.width(), left.height(), right, "Stereo images");
  msgs::StereoPair pair = convert::to_message(
      convert::StereoImages{convert::from_message(left), convert::from_message(right)});
  *pair.mutable_header() = left.header();
  return pair;
}

msgs::DepthImage colored(const msgs::DepthImage& depth, const msgs::Image& color) {
  require_same_size(depth.width(), depth.height(), color, "Depth and colour");
  msgs::DepthImage result = depth;
  const geometry::ColorImage image = convert::from_message(color);
  result.set_has_color(true);
  result.mutable_data()->append(reinterpret_cast<const char*>(image.data.data()),
                                3 * image.data.size());
  return result;
}

}  // namespace prehend::ros
