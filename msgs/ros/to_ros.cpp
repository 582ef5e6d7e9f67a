#include "msgs/ros/to_ros.h"

#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <google/protobuf/message.h>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "foxglove/RawImage.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"

namespace prehend::ros {
namespace {

using geometry::InputError;
using recording::RosError;
using recording::RosValue;
using Fields = RosValue::Fields;
using List = RosValue::List;

constexpr const char* kMend = "Mend the node that published it";
constexpr std::int64_t kSecond = 1'000'000'000;  // ns

std::int64_t nanoseconds(const google::protobuf::Timestamp& time) {
  return kSecond * time.seconds() + time.nanos();
}

RosValue moment(const google::protobuf::Timestamp& time, const std::string& frame,
                Version version) {
  return ros_header(nanoseconds(time), frame, version);
}

RosValue vector(double x, double y, double z) {
  return RosValue(Fields{{"x", ros_number(x)}, {"y", ros_number(y)}, {"z", ros_number(z)}});
}

// Numbers of sensor_msgs/PointField.
std::int64_t field_type(::foxglove::PackedElementField::NumericType type) {
  using Field = ::foxglove::PackedElementField;
  switch (type) {
    case Field::INT8:
      return 1;
    case Field::UINT8:
      return 2;
    case Field::INT16:
      return 3;
    case Field::UINT16:
      return 4;
    case Field::INT32:
      return 5;
    case Field::UINT32:
      return 6;
    case Field::FLOAT32:
      return 7;
    case Field::FLOAT64:
      return 8;
    default:
      throw InputError("A cloud has a field without a type", kMend);
  }
}

/// Where red, green and blue are, one after the other within four bytes.
std::optional<std::size_t> color_offset(const ::foxglove::PointCloud& cloud) {
  std::map<std::string, std::size_t> offsets;
  for (const auto& field : cloud.fields()) {
    if (field.type() == ::foxglove::PackedElementField::UINT8) {
      offsets[field.name()] = field.offset();
    }
  }
  if (!offsets.count("red") || !offsets.count("green") || !offsets.count("blue")) return {};
  const std::size_t red = offsets["red"];
  if (offsets["green"] != red + 1 || offsets["blue"] != red + 2 || red % 4 != 0 ||
      red + 4 > cloud.point_stride()) {
    return {};
  }
  return red;
}

RosValue point_field(std::string_view name, std::size_t offset, std::int64_t type) {
  return RosValue(Fields{{"name", ros_text(name)},
                         {"offset", ros_integer(static_cast<std::int64_t>(offset))},
                         {"datatype", ros_integer(type)},
                         {"count", ros_integer(1)}});
}

std::string cloud_to_ros(const ::foxglove::PointCloud& cloud, Version version) {
  constexpr std::int64_t kFloat32 = 7;
  const std::size_t stride = cloud.point_stride();
  if (stride == 0 || cloud.data().size() % stride != 0) {
    throw InputError("A cloud's data is no whole number of points", kMend);
  }
  const auto color = color_offset(cloud);
  List fields;
  for (const auto& field : cloud.fields()) {
    const bool is_color = color && (field.name() == "red" || field.name() == "green" ||
                                    field.name() == "blue" || field.name() == "alpha");
    if (!is_color)
      fields.push_back(point_field(field.name(), field.offset(), field_type(field.type())));
  }
  // A number 0xAARRGGBB, little endian, that PCL and RViz call a float.
  if (color) fields.push_back(point_field("rgb", *color, kFloat32));
  const std::size_t count = cloud.data().size() / stride;
  std::string data = cloud.data();
  for (std::size_t i = 0; color && i < count; ++i) {
    std::swap(data[i * stride + *color], data[i * stride + *color + 2]);
  }
  return type_of("sensor_msgs/PointCloud2", version)
      .write(RosValue(Fields{{"header", moment(cloud.timestamp(), cloud.frame_id(), version)},
                             {"height", ros_integer(1)},
                             {"width", ros_integer(static_cast<std::int64_t>(count))},
                             {"fields", RosValue(std::move(fields))},
                             {"point_step", ros_integer(static_cast<std::int64_t>(stride))},
                             {"row_step", ros_integer(static_cast<std::int64_t>(data.size()))},
                             {"data", ros_bytes(data)},
                             {"is_dense", ros_integer(1)}}),
             encoding_of(version));
}

std::string image_to_ros(const ::foxglove::RawImage& image, Version version) {
  if (image.data().size() != std::uint64_t{image.step()} * image.height()) {
    throw InputError("An image's data does not fit its size", kMend);
  }
  return type_of("sensor_msgs/Image", version)
      .write(RosValue(Fields{{"header", moment(image.timestamp(), image.frame_id(), version)},
                             {"height", ros_integer(image.height())},
                             {"width", ros_integer(image.width())},
                             {"encoding", ros_text(image.encoding())},
                             {"step", ros_integer(image.step())},
                             {"data", ros_bytes(image.data())}}),
             encoding_of(version));
}

std::string compressed_to_ros(const ::foxglove::CompressedImage& image, Version version) {
  return type_of("sensor_msgs/CompressedImage", version)
      .write(RosValue(Fields{{"header", moment(image.timestamp(), image.frame_id(), version)},
                             {"format", ros_text(image.format())},
                             {"data", ros_bytes(image.data())}}),
             encoding_of(version));
}

std::string frames_to_ros(const ::foxglove::FrameTransforms& frames, Version version) {
  List list;
  for (const auto& frame : frames.transforms()) {
    const auto& p = frame.translation();
    const auto& q = frame.rotation();
    list.emplace_back(Fields{
        {"header", moment(frame.timestamp(), frame.parent_frame_id(), version)},
        {"child_frame_id", ros_text(frame.child_frame_id())},
        {"transform", RosValue(Fields{{"translation", vector(p.x(), p.y(), p.z())},
                                      {"rotation", RosValue(Fields{{"x", ros_number(q.x())},
                                                                   {"y", ros_number(q.y())},
                                                                   {"z", ros_number(q.z())},
                                                                   {"w", ros_number(q.w())}})}})}});
  }
  return type_of("tf2_msgs/TFMessage", version)
      .write(RosValue(Fields{{"transforms", RosValue(std::move(list))}}), encoding_of(version));
}

/// Of both versions' constants.
std::int64_t log_level(::foxglove::Log::Level level, Version version) {
  constexpr std::array<std::array<std::int64_t, 2>, 6> kLevels = {
      {{2, 20}, {1, 10}, {2, 20}, {4, 30}, {8, 40}, {16, 50}}};
  const auto index = static_cast<std::size_t>(level);
  return kLevels[index < kLevels.size() ? index : 0][version == Version::kRos1 ? 0 : 1];
}

std::string log_to_ros(const ::foxglove::Log& log, Version version) {
  Fields fields{{"level", ros_integer(log_level(log.level(), version))},
                {"name", ros_text(log.name())},
                {"msg", ros_text(log.message())},
                {"file", ros_text(log.file())},
                {"line", ros_integer(log.line())}};
  if (version == Version::kRos1) {
    fields.emplace_back("header", moment(log.timestamp(), {}, version));
    return type_of("rosgraph_msgs/Log", version)
        .write(RosValue(std::move(fields)), encoding_of(version));
  }
  fields.emplace_back("stamp", ros_time(nanoseconds(log.timestamp()), version));
  return type_of("rcl_interfaces/Log", version)
      .write(RosValue(std::move(fields)), encoding_of(version));
}

std::string camera_to_ros(const msgs::CameraInfo& info, Version version) {
  const bool one = version == Version::kRos1;
  const std::array<double, 5> d{};
  const std::array<double, 9> k{info.fx(), 0, info.cx(), 0, info.fy(), info.cy(), 0, 0, 1};
  const std::array<double, 9> r{1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::array<double, 12> p{info.fx(), 0, info.cx(), 0, 0, info.fy(),
                                 info.cy(), 0, 0,         0, 1, 0};
  return type_of("sensor_msgs/CameraInfo", version)
      .write(RosValue(Fields{
                 {"header", ros_header(info.header().stamp(), info.header().frame_id(), version)},
                 {"height", ros_integer(info.height())},
                 {"width", ros_integer(info.width())},
                 {"distortion_model", ros_text("plumb_bob")},
                 {one ? "D" : "d", ros_numbers(d.data(), d.size())},
                 {one ? "K" : "k", ros_numbers(k.data(), k.size())},
                 {one ? "R" : "r", ros_numbers(r.data(), r.size())},
                 {one ? "P" : "p", ros_numbers(p.data(), p.size())}}),
             encoding_of(version));
}

std::string joints_to_ros(const msgs::JointState& joints, Version version) {
  List names;
  for (const std::string& name : joints.name()) names.push_back(ros_text(name));
  const auto numbers = [](const auto& field) {
    return ros_numbers(field.data(), static_cast<std::size_t>(field.size()));
  };
  return type_of("sensor_msgs/JointState", version)
      .write(RosValue(Fields{{"header", ros_header(joints.header().stamp(),
                                                   joints.header().frame_id(), version)},
                             {"name", RosValue(std::move(names))},
                             {"position", numbers(joints.position())},
                             {"velocity", numbers(joints.velocity())},
                             {"effort", numbers(joints.effort())}}),
             encoding_of(version));
}

std::string wrench_to_ros(const msgs::Wrench& wrench, Version version) {
  const auto& force = wrench.wrench().force();
  const auto& torque = wrench.wrench().torque();
  return type_of("geometry_msgs/WrenchStamped", version)
      .write(
          RosValue(Fields{
              {"header", ros_header(wrench.header().stamp(), wrench.header().frame_id(), version)},
              {"wrench",
               RosValue(Fields{{"force", vector(force.x(), force.y(), force.z())},
                               {"torque", vector(torque.x(), torque.y(), torque.z())}})}}),
          encoding_of(version));
}

std::string clock_to_ros(const msgs::Clock& clock, Version version) {
  return type_of("rosgraph_msgs/Clock", version)
      .write(RosValue(Fields{{"clock", ros_time(clock.time(), version)}}), encoding_of(version));
}

struct Conversion {
  const google::protobuf::Descriptor* from;
  std::string to;
  std::function<std::string(const google::protobuf::Message&, Version)> convert;
  std::optional<Version> only;  // of the two
};

template <class Message>
Conversion conversion(const char* to, std::string (*convert)(const Message&, Version),
                      std::optional<Version> only = {}) {
  return {Message::descriptor(), to,
          [convert](const google::protobuf::Message& message, Version version) {
            return convert(static_cast<const Message&>(message), version);
          },
          only};
}

const std::vector<Conversion>& conversions_to_ros() {
  static const std::vector<Conversion> kAll = {
      conversion("geometry_msgs/WrenchStamped", wrench_to_ros),
      conversion("rcl_interfaces/Log", log_to_ros, Version::kRos2),
      conversion("rosgraph_msgs/Clock", clock_to_ros),
      conversion("rosgraph_msgs/Log", log_to_ros, Version::kRos1),
      conversion("sensor_msgs/CameraInfo", camera_to_ros),
      conversion("sensor_msgs/CompressedImage", compressed_to_ros),
      conversion("sensor_msgs/Image", image_to_ros),
      conversion("sensor_msgs/JointState", joints_to_ros),
      conversion("sensor_msgs/PointCloud2", cloud_to_ros),
      conversion("tf2_msgs/TFMessage", frames_to_ros)};
  return kAll;
}

bool goes_with(const Conversion& conversion, const google::protobuf::Descriptor& type,
               Version version) {
  return conversion.from->full_name() == type.full_name() &&
         (!conversion.only || *conversion.only == version);
}

RosValue seconds_and_rest(std::int64_t seconds, std::int64_t rest) {
  return RosValue(Fields{{"sec", ros_integer(seconds)}, {"nanosec", ros_integer(rest)}});
}

}  // namespace

std::vector<std::string> types_in_ros(const google::protobuf::Descriptor& type, Version version) {
  std::vector<std::string> types;
  for (const Conversion& one : conversions_to_ros()) {
    if (goes_with(one, type, version)) types.push_back(one.to);
  }
  return types;
}

std::string to_ros(const google::protobuf::Message& message, const std::string& type,
                   Version version) {
  for (const Conversion& one : conversions_to_ros()) {
    if (one.to == type && goes_with(one, *message.GetDescriptor(), version)) {
      return one.convert(message, version);
    }
  }
  throw RosError("a " + message.GetDescriptor()->full_name() + " does not become a " + type);
}

RosValue ros_time(std::int64_t nanoseconds, Version version) {
  const std::int64_t most = version == Version::kRos1 ? std::numeric_limits<std::uint32_t>::max()
                                                      : std::numeric_limits<std::int32_t>::max();
  if (nanoseconds < 0 || nanoseconds / kSecond > most) {
    throw InputError("The time " + std::to_string(nanoseconds) + " ns is none that ROS can say",
                     kMend);
  }
  return seconds_and_rest(nanoseconds / kSecond, nanoseconds % kSecond);
}

RosValue ros_duration(std::int64_t nanoseconds) {
  std::int64_t seconds = nanoseconds / kSecond, rest = nanoseconds % kSecond;
  if (rest < 0) {
    rest += kSecond;
    --seconds;
  }
  if (seconds != static_cast<std::int32_t>(seconds)) {
    throw InputError("The duration " + std::to_string(nanoseconds) + " ns is none that ROS can say",
                     kMend);
  }
  return seconds_and_rest(seconds, rest);
}

RosValue ros_header(std::int64_t stamp, std::string_view frame, Version version) {
  return RosValue(Fields{{"stamp", ros_time(stamp, version)}, {"frame_id", ros_text(frame)}});
}

RosValue ros_text(std::string_view text) { return RosValue(text); }
RosValue ros_integer(std::int64_t number) { return RosValue(number); }
RosValue ros_number(double number) { return RosValue(number); }
RosValue ros_numbers(const double* data, std::size_t count) {
  return RosValue(
      RosValue::Numbers{'f', 8, {reinterpret_cast<const char*>(data), count * sizeof(double)}});
}
RosValue ros_bytes(std::string_view bytes) { return RosValue(RosValue::Numbers{'u', 1, bytes}); }
RosValue ros_texts(const std::vector<std::string>& texts) {
  List list;
  for (const std::string& text : texts) list.push_back(ros_text(text));
  return RosValue(std::move(list));
}

}  // namespace prehend::ros
