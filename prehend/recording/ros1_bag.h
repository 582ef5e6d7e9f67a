#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/recording/byte_file.h"

namespace prehend::recording {

/// What a ROS 1 bag says of one publisher's connection.
struct Ros1Connection {
  std::string topic;
  std::string type;        ///< "sensor_msgs/PointCloud2"
  std::string definition;  ///< the type's text and, after lines of "=", those of what it contains
};

struct Ros1Message {
  std::uint32_t connection = 0;  ///< number of it
  std::uint64_t time = 0;        ///< when it was received [ns]
  std::string_view data;         ///< until the next call of next()
};

/// Reads a bag of ROS 1, format 2.0 (wiki.ros.org/Bags/Format/2.0), from its front, chunk by chunk,
/// uncompressed or by bzip2 or LZ4. Needs no index, so that bags that were never closed (.active)
/// can be read as well. What is damaged is skipped and listed in problems().
class Ros1BagReader {
 public:
  /// @throws McapError when the file cannot be read or is no such bag.
  explicit Ros1BagReader(const std::string& path);

  /// The next message in the file's order, nothing at its end. Its connection is known by then.
  std::optional<Ros1Message> next();

  /// By number, as far as read.
  const std::map<std::uint32_t, Ros1Connection>& connections() const { return connections_; }
  const std::vector<std::string>& problems() const { return problems_; }

  /// Whether the file begins as a bag of any version.
  static bool is_bag(const std::string& path);

 private:
  using Fields = std::map<std::string, std::string_view>;
  struct Record {
    Fields header;
    std::string_view data;
    std::size_t length = 0;  // of all
  };

  bool load_chunk();
  std::optional<Ros1Message> take(const Record& record);
  void take_connection(const Record& record);
  void report(std::uint64_t offset, const std::string& what);

  const ByteFile file_;
  std::uint64_t position_ = 0;  // of the next record outside of chunks
  std::string outside_;         // bytes of the last one
  std::string chunk_;           // what is left of the open chunk begins at chunk_position_
  std::size_t chunk_position_ = 0;
  std::uint64_t chunk_offset_ = 0;
  std::map<std::uint32_t, Ros1Connection> connections_;
  std::vector<std::string> problems_;
};

}  // namespace prehend::recording
