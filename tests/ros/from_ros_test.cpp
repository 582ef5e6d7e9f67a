// Messages of ROS as prehend's own.

#include "msgs/ros/from_ros.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "msgs/convert/camera_images.h"
#include "msgs/convert/geometry.h"
#include "prehend/geometry/errors.h"
#include "tests/recording/ros_test_files.h"

namespace prehend::ros {
namespace {

using convert::ColoredDepth;
using convert::from_message;
using geometry::InputError;
using recording::RosBytes;
using recording::RosEncoding;
using recording::RosType;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::unique_ptr<google::protobuf::Message> converted(const std::string& type,
                                                     const std::string& fields,
                                                     const RosBytes& message) {
  const RosType reader(type, "Header header\n" + fields + recording::kStampedHeader);
  return from_ros(type, reader.read(message.bytes(), RosEncoding::kRos1));
}

RosBytes stamped() { return RosBytes(false).header(12, 34, "cam"); }

/// @param data  rows of `step` bytes
std::unique_ptr<google::protobuf::Message> image(std::uint32_t width, std::uint32_t height,
                                                 const std::string& encoding, std::uint32_t step,
                                                 const std::vector<std::uint8_t>& data,
                                                 std::uint8_t big_endian = 0) {
  RosBytes bytes = stamped();
  bytes.number(height).number(width).text(encoding).number(big_endian).number(step).list(data);
  return converted("sensor_msgs/Image", recording::kImageFields, bytes);
}

TEST(RosImage, ColoursAreRedGreenBlueAndRowsWithoutPadding) {
  const auto message = image(1, 2, "bgr8", 4, {1, 2, 3, 99, 4, 5, 6, 99});
  const auto* found = dynamic_cast<const msgs::Image*>(message.get());
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->header().stamp(), 12'000'000'034);
  EXPECT_EQ(found->header().frame_id(), "cam");
  EXPECT_EQ(found->data(), std::string("\3\2\1\6\5\4"));
  const auto rgba = image(1, 1, "rgba8", 4, {1, 2, 3, 4});
  EXPECT_EQ(dynamic_cast<const msgs::Image&>(*rgba).data(), std::string("\1\2\3"));
  const auto grey = image(2, 1, "mono8", 3, {7, 8, 9});
  EXPECT_EQ(dynamic_cast<const msgs::Image&>(*grey).data(), std::string("\7\10"));
}

TEST(RosImage, DepthIsInMetres) {
  const auto counts = image(2, 1, "16UC1", 4, {0xE8, 3, 0, 0});  // 1000 mm, unknown
  const ColoredDepth seen = from_message(dynamic_cast<const msgs::DepthImage&>(*counts));
  EXPECT_FLOAT_EQ(seen.depth.data[0], 1);
  EXPECT_TRUE(std::isnan(seen.depth.data[1]));
  std::vector<std::uint8_t> floats(8);
  const float metres[] = {1.25F, std::numeric_limits<float>::quiet_NaN()};
  std::memcpy(floats.data(), metres, 8);
  const auto floating = image(2, 1, "32FC1", 8, floats);
  const ColoredDepth same = from_message(dynamic_cast<const msgs::DepthImage&>(*floating));
  EXPECT_NEAR(static_cast<double>(same.depth.data[0]), 1.25, 5e-5);
  EXPECT_TRUE(std::isnan(same.depth.data[1]));
}

TEST(RosImage, WhatCannotBeIsRefused) {
  EXPECT_THAT(
      [] {
        image(2, 2, "mono8", 2, {1, 2, 3});
      },
      ThrowsMessage<InputError>(HasSubstr("2x2 with rows of 2 bytes has 3 bytes")));
  EXPECT_THROW(image(0, 2, "mono8", 2, {}), InputError);
  EXPECT_THROW(image(0xFFFFFFFF, 0xFFFFFFFF, "mono8", 1, {1}), InputError);
  EXPECT_THROW(image(2, 1, "mono8", 1, {1, 2}), InputError);
  EXPECT_THROW(image(1, 1, "16UC1", 2, {1, 2}, 1), InputError);
  EXPECT_THAT([] { image(1, 1, "bayer_rggb8", 1, {1}); },
              ThrowsMessage<InputError>(HasSubstr("'bayer_rggb8'")));
}

TEST(RosImage, CompressedOnesAreDecoded) {
  const auto compressed = [](const std::string& format, const std::vector<std::uint8_t>& data) {
    RosBytes bytes = stamped();
    bytes.text(format).list(data);
    return converted("sensor_msgs/CompressedImage", "string format\nuint8[] data\n", bytes);
  };
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(2, 3, CV_8UC3, cv::Scalar(10, 20, 30)), png);
  const auto color = compressed("bgr8; png compressed bgr8", png);
  EXPECT_EQ(dynamic_cast<const msgs::Image&>(*color).data().substr(0, 3), "\x1e\x14\x0a");
  cv::imencode(".png", cv::Mat(2, 3, CV_16UC1, cv::Scalar(1500)), png);
  png.insert(png.begin(), 12, 0);
  const auto depth = compressed("16UC1; compressedDepth", png);
  EXPECT_FLOAT_EQ(from_message(dynamic_cast<const msgs::DepthImage&>(*depth)).depth.data[0], 1.5F);
  EXPECT_THROW(compressed("jpeg", {1, 2, 3}), InputError);
  EXPECT_THROW(compressed("jpeg", {}), InputError);
}

TEST(RosCameraInfo, IsOfTheRectifiedImage) {
  const auto camera = [](const std::vector<double>& K, const std::vector<double>& P) {
    RosBytes bytes = stamped();
    bytes.number(std::uint32_t{48}).number(std::uint32_t{64}).text("plumb_bob");
    bytes.list<double>({0.1}).array(K).array(std::vector<double>(9)).array(P);
    bytes.number(std::uint32_t{0}).number(std::uint32_t{0});
    const auto made = converted("sensor_msgs/CameraInfo", recording::kCameraFields, bytes);
    return dynamic_cast<const msgs::CameraInfo&>(*made);
  };
  const std::vector<double> K{50, 0, 31, 0, 51, 23, 0, 0, 1};
  const msgs::CameraInfo right = camera(K, {40, 0, 30, -4, 0, 41, 22, 0, 0, 0, 1, 0});
  EXPECT_EQ(right.width(), 64u);
  EXPECT_EQ(right.fx(), 40);
  EXPECT_EQ(right.cy(), 22);
  EXPECT_DOUBLE_EQ(right.baseline(), 0.1);
  EXPECT_EQ(camera(K, std::vector<double>(12)).fx(), 50) << "no projection is given";
  EXPECT_THROW(camera(std::vector<double>(9), std::vector<double>(12)), InputError);
}

RosBytes cloud(std::uint32_t width, std::uint32_t height, std::uint32_t row_step,
               const std::vector<float>& numbers) {
  RosBytes bytes = stamped();
  bytes.number(height).number(width).number(std::uint32_t{4});
  const char* names[] = {"x", "y", "z", "rgb"};
  for (std::uint32_t k = 0; k < 4; ++k) {
    bytes.text(names[k]).number(4 * k).number(std::uint8_t{7}).number(std::uint32_t{1});
  }
  bytes.number(std::uint8_t{0}).number(std::uint32_t{16}).number(row_step);
  bytes.number(static_cast<std::uint32_t>(4 * numbers.size())).array(numbers);
  bytes.number(std::uint8_t{0});
  return bytes;
}
const std::string kCloudFields =
    "uint32 height\nuint32 width\nF[] fields\nbool is_bigendian\nuint32 point_step\n"
    "uint32 row_step\nuint8[] data\nbool is_dense\n"
    "===\nMSG: sensor_msgs/F\nuint8 FLOAT32=7\nstring name\nuint32 offset\nuint8 datatype\n"
    "uint32 count\n";

TEST(RosPointCloud, HasPointsColoursAndOrder) {
  const std::uint32_t packed = 0xFF102030;
  float color = 0;
  std::memcpy(&color, &packed, 4);
  const auto made = converted("sensor_msgs/PointCloud2", kCloudFields,
                              cloud(1, 2, 16, {1, 2, 3, color, NAN, 0, 0, color}));
  const geometry::PointCloud found = from_message(dynamic_cast<const msgs::PointCloud&>(*made));
  EXPECT_EQ(found.width, 1);
  EXPECT_EQ(found.height, 2);
  EXPECT_EQ(found.points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_FALSE(geometry::is_finite(found.points[1]));
  EXPECT_THAT(found.colors[0], ElementsAre(0x10, 0x20, 0x30));
  EXPECT_THROW(converted("sensor_msgs/PointCloud2", kCloudFields, cloud(1, 2, 16, {1, 2, 3, 4})),
               InputError);
  EXPECT_THROW(
      converted("sensor_msgs/PointCloud2", kCloudFields, cloud(0x7FFFFFFF, 2, 16, {1, 2, 3, 4})),
      InputError);
  EXPECT_THROW(converted("sensor_msgs/PointCloud2", kCloudFields, cloud(2, 1, 16, {1, 2, 3, 4})),
               InputError);
}

TEST(RosOthers, AreLeftToTheCaller) {
  EXPECT_EQ(from_ros("std_msgs/String", recording::RosValue(std::string_view("x"))), nullptr);
  EXPECT_THAT(ros_types(), testing::Contains("sensor_msgs/Image"));
  EXPECT_EQ(recording::ros_type_name("sensor_msgs/msg/Image"), "sensor_msgs/Image");
}

}  // namespace
}  // namespace prehend::ros
