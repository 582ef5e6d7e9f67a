#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

// Messages of ROS 1 and ROS 2, read and written by definitions as their recordings carry them.
namespace prehend::recording {

/// A definition or message that cannot be read, or a field that it does not have.
class RosError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A type's name without "msg/" in its middle: "sensor_msgs/msg/Image" is "sensor_msgs/Image".
std::string ros_type_name(std::string_view name);

/// How messages are laid out in bytes.
enum class RosEncoding {
  kRos1,  // wiki.ros.org/msg and roscpp's serialisation: packed, little endian
  kCdr,   // of ROS 2: XCDR version 1, plain (OMG DDSI-RTPS 10.5), little endian
};

/// A field's value: a number, a text, a list, a message.
class RosValue {
 public:
  using List = std::vector<RosValue>;
  using Fields = std::vector<std::pair<std::string, RosValue>>;
  /// Numbers of one size, as they are in the message, little endian.
  struct Numbers {
    char kind = 'u';  // 'i' signed, 'u' unsigned, 'f' floating
    std::size_t size = 1;
    std::string_view bytes;
  };
  using Content =
      std::variant<std::int64_t, std::uint64_t, double, std::string_view, Numbers, List, Fields>;
  explicit RosValue(Content content) : content_(std::move(content)) {}
  const Content& content() const { return content_; }

  /// A message's field. @throws RosError naming it when there is none.
  const RosValue& operator[](std::string_view field) const;
  bool has(std::string_view field) const;
  /// @throws RosError when it is something else, or too large.
  std::int64_t integer() const;
  double number() const;
  std::string_view text() const;
  std::vector<double> numbers() const;
  /// Of a list of bytes, without a copy.
  std::string_view bytes() const;
  const List& list() const;

 private:
  Content content_;
};

/// A message type with all that it contains, from the text that bags and MCAP files carry
/// ("ros1msg", "ros2msg").
class RosType {
 public:
  /// @param name "sensor_msgs/Image" or "sensor_msgs/msg/Image"
  /// @throws RosError naming the line that is not understood, or a type that is not described.
  RosType(const std::string& name, std::string_view definition);

  /// @returns values that point into `bytes`. @throws RosError when these are not such a message.
  RosValue read(std::string_view bytes, RosEncoding encoding) const;

  /// The opposite of read(). Fields that `message` does not have are 0 or empty.
  /// @throws RosError naming a field that the type does not have, whose value is of another kind,
  /// or too large for it.
  std::string write(const RosValue& message, RosEncoding encoding) const;

 private:
  struct Field {
    std::string name;
    std::string type;  // a primitive's or a message's name
    bool is_list = false;
    std::size_t length = 0;  // of a list that is always as long; 0: any
  };
  class Reader;
  class Writer;

  static Field parse_field(std::string_view line, const std::string& package);
  void parse(const std::string& name, std::string_view text);
  void check(const std::string& type, std::size_t depth) const;

  std::string root_;
  std::map<std::string, std::vector<Field>> messages_;
};

}  // namespace prehend::recording
