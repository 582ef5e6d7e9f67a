#include "tools/bag_export/pictures.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "msgs/convert/geometry.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/cloud_files.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// The same message as the type of this program.
template <class Type>
Type as(const Message& message) {
  Type result;
  if (!result.ParseFromString(message.SerializeAsString())) {
    throw std::runtime_error("is another " + message.GetDescriptor()->full_name() +
                             " than this program's");
  }
  return result;
}

bool is_a(const Message& message, const google::protobuf::Descriptor& type) {
  return message.GetDescriptor()->full_name() == type.full_name();
}

void write_png(const fs::path& path, const cv::Mat& image) {
  fs::create_directories(path.parent_path());
  bool written = false;
  try {
    written = cv::imwrite(path.string(), image);
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) throw std::runtime_error("cannot write " + path.string());
}

// width * height pixels of `bytes_each`; throws when `data` has another size.
void require_size(const char* what, std::uint64_t width, std::uint64_t height,
                  std::uint64_t bytes_each, const std::string& data) {
  constexpr std::uint64_t kWidest = 1 << 16;  // pixels; more is no picture
  if (width > 0 && height > 0 && width <= kWidest && height <= kWidest &&
      width * height * bytes_each == data.size()) {
    return;
  }
  throw std::runtime_error(fmt::format("{}: {} x {} pixels of {} bytes do not make {} bytes", what,
                                       width, height, bytes_each, data.size()));
}

int write_stereo(const msgs::StereoPair& pair, const fs::path& stem) {
  if (pair.channels() != 1 && pair.channels() != 3) {
    throw std::runtime_error(fmt::format("a picture of {} channels", pair.channels()));
  }
  require_size("data", pair.width(), pair.height(), 2 * pair.channels(), pair.data());
  const char* sides[] = {"left", "right"};
  const std::size_t size = pair.data().size() / 2;
  for (std::size_t side = 0; side < 2; ++side) {
    const cv::Mat rgb(static_cast<int>(pair.height()), static_cast<int>(pair.width()),
                      pair.channels() == 3 ? CV_8UC3 : CV_8UC1,
                      const_cast<char*>(pair.data().data() + side * size));
    cv::Mat image = rgb.clone();
    if (pair.channels() == 3) {  // the files' order is blue, green, red
      image.forEach<cv::Vec3b>([](cv::Vec3b& pixel, const int*) { std::swap(pixel[0], pixel[2]); });
    }
    write_png(fmt::format("{}_{}.png", stem.string(), sides[side]), image);
  }
  return 2;
}

int write_depth(const msgs::ObjectHypotheses& objects, const fs::path& stem) {
  if (objects.depth().empty()) return 0;
  const auto& camera = objects.camera();
  require_size("depth", camera.width(), camera.height(), 2, objects.depth());
  const cv::Mat depth(static_cast<int>(camera.height()), static_cast<int>(camera.width()), CV_16UC1,
                      const_cast<char*>(objects.depth().data()));
  write_png(stem.string() + "_depth.png", depth);
  return 1;
}

int write_clouds(const Message& message, const fs::path& stem, const std::string& field_name);

int write_part(const Message& message, const fs::path& stem, const std::string& name) {
  if (!is_a(message, *msgs::PointCloud::descriptor())) return write_clouds(message, stem, name);
  const auto cloud = as<msgs::PointCloud>(message);
  if (cloud.count() == 0) return 0;
  const fs::path path = stem.string() + (name.empty() ? "" : "_" + name) + ".pcd";
  fs::create_directories(path.parent_path());
  try {
    geometry::write_cloud_file(path, convert::from_message(cloud));
  } catch (const std::exception& error) {
    throw std::runtime_error((name.empty() ? "cloud" : name) + ": " + error.what());
  }
  return 1;
}

int write_clouds(const Message& message, const fs::path& stem, const std::string& name) {
  const auto& reflection = *message.GetReflection();
  int count = 0;
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    const std::string part = (name.empty() ? "" : name + ".") + field->name();
    if (!field->is_repeated()) {
      count += write_part(reflection.GetMessage(message, field), stem, part);
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      count += write_part(reflection.GetRepeatedMessage(message, field, i), stem,
                          fmt::format("{}[{}]", part, i));
    }
  }
  return count;
}

}  // namespace

int write_pictures(const Message& message, const fs::path& stem) {
  if (is_a(message, *msgs::StereoPair::descriptor())) {
    return write_stereo(as<msgs::StereoPair>(message), stem);
  }
  int count = write_part(message, stem, "");
  if (is_a(message, *msgs::ObjectHypotheses::descriptor())) {
    count += write_depth(as<msgs::ObjectHypotheses>(message), stem);
  }
  return count;
}

}  // namespace prehend::tools
