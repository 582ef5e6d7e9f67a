#pragma once

#include <bzlib.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "prehend/recording/chunk_compression.h"

// Bags and messages of ROS as tests need them, written from the formats' descriptions.
namespace prehend::recording {

/// Serialises fields one after the other, as roscpp or, with alignment, as CDR does.
class RosBytes {
 public:
  explicit RosBytes(bool cdr) : cdr_(cdr) {
    if (cdr) bytes_ = std::string("\0\1\0\0", 4);
  }
  template <class Number>
  RosBytes& number(Number value) {
    align(sizeof value);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  RosBytes& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size() + (cdr_ ? 1 : 0)));
    bytes_ += value;
    if (cdr_) bytes_ += '\0';
    return *this;
  }
  template <class Number>
  RosBytes& list(const std::vector<Number>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    return array(values);
  }
  template <class Number>
  RosBytes& array(const std::vector<Number>& values) {
    for (const Number value : values) number(value);
    return *this;
  }
  /// std_msgs/Header: ROS 1 has a sequence number in it.
  RosBytes& header(std::uint32_t seconds, std::uint32_t nanoseconds, const std::string& frame) {
    if (!cdr_) number(std::uint32_t{7});
    return number(seconds).number(nanoseconds).text(frame);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void align(std::size_t size) {
    while (cdr_ && (bytes_.size() - 4) % size != 0) bytes_ += '\0';
  }
  const bool cdr_;
  std::string bytes_;
};

/// Definitions as ROS gives them.
inline const std::string kStampedHeader =
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "# Standard metadata, with = in a comment\n"
    "uint32 seq\ntime stamp\nstring frame_id\n";
inline const std::string kStampedHeader2 =
    "================================================================================\n"
    "MSG: std_msgs/Header\n"
    "builtin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
inline const std::string kJointState =
    "# joints\nHeader header\n\nstring[] name\nfloat64[] position\nfloat64[] velocity # rad/s\n"
    "float64[] effort\n" +
    kStampedHeader;
inline const std::string kJointState2 =
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
    "float64[] effort\n" +
    kStampedHeader2;
inline const std::string kImageFields =
    "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n";
inline const std::string kCameraFields =
    "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] D\nfloat64[9] K\n"
    "float64[9] R\nfloat64[12] P\nuint32 binning_x\nuint32 binning_y\n";

/// A bag of one chunk for each call of chunk().
class BagBytes {
 public:
  using Header = std::vector<std::pair<std::string, std::string>>;

  BagBytes() {
    add(&bytes_, {{"op", "\x03"}, {"index_pos", std::string(8, '\0')}}, std::string(4000, ' '));
  }
  static std::string u32(std::uint32_t value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }
  void connection(std::uint32_t id, const std::string& topic, const std::string& type,
                  const std::string& definition) {
    std::string about;
    for (const auto& [name, value] : Header{
             {"topic", topic}, {"type", type}, {"md5sum", "*"}, {"message_definition", definition}})
      field(&about, name, value);
    add(&chunk_, {{"op", "\x07"}, {"conn", u32(id)}, {"topic", topic}}, about);
  }
  void message(std::uint32_t id, std::uint32_t seconds, const std::string& data) {
    add(&chunk_, {{"op", "\x02"}, {"conn", u32(id)}, {"time", u32(seconds) + u32(5)}}, data);
  }
  void chunk(const std::string& compression) {
    std::string packed = chunk_;
    if (compression == "lz4") packed = compress_lz4(chunk_);
    if (compression == "bz2") {
      packed.resize(chunk_.size() + 1000);
      auto size = static_cast<unsigned>(packed.size());
      if (BZ2_bzBuffToBuffCompress(packed.data(), &size, chunk_.data(),
                                   static_cast<unsigned>(chunk_.size()), 9, 0, 0) != BZ_OK)
        throw std::runtime_error("bzip2 failed");
      packed.resize(size);
    }
    const auto size = static_cast<std::uint32_t>(chunk_.size());
    add(&bytes_, {{"op", "\x05"}, {"compression", compression}, {"size", u32(size)}}, packed);
    chunk_.clear();
  }
  std::string file() const { return "#ROSBAG V2.0\n" + bytes_; }

 private:
  static void field(std::string* to, const std::string& name, const std::string& value) {
    const std::string text = name + "=" + value;
    *to += u32(static_cast<std::uint32_t>(text.size())) + text;
  }
  static void add(std::string* to, const Header& header, const std::string& data) {
    std::string fields;
    for (const auto& [name, value] : header) field(&fields, name, value);
    *to += u32(static_cast<std::uint32_t>(fields.size())) + fields;
    *to += u32(static_cast<std::uint32_t>(data.size())) + data;
  }
  std::string bytes_, chunk_;
};

/// A JointState of two joints.
inline std::string joint_state(bool cdr, double first) {
  RosBytes bytes(cdr);
  bytes.header(100, 5, "base").number(std::uint32_t{2}).text("a").text("bcd");
  return bytes.list<double>({first, -2}).list<double>({}).list<double>({0.5, 0.25}).bytes();
}

}  // namespace prehend::recording
