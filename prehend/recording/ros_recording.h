#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/ros1_bag.h"
#include "prehend/recording/ros_message.h"

namespace prehend::recording {

/// A recorded message with what reads it.
struct RosRecordedMessage {
  std::string topic;
  std::string type;        ///< "sensor_msgs/Image"
  std::uint64_t time = 0;  ///< when it was recorded [ns]
  RosEncoding encoding = RosEncoding::kRos1;
  const RosType* reader = nullptr;  ///< nullptr: its definition is not understood, see problems()
  std::string_view data;            ///< until the next call of next()

  /// @throws RosError when `reader` is nullptr or the data are no such message.
  RosValue read() const;
};

/// A recording of ROS: a bag of ROS 1, or an MCAP file of ROS 2 or ROS 1 (schemas "ros2msg" or
/// "ros1msg", messages "cdr" or "ros1").
class RosRecording {
 public:
  /// @throws McapError when the file is neither.
  explicit RosRecording(const std::string& path);

  /// Messages of a bag in the file's order, of an MCAP file by time; nothing at the end.
  std::optional<RosRecordedMessage> next();

  /// What was skipped and why, in order of discovery, each once.
  std::vector<std::string> problems() const;

 private:
  std::optional<RosRecordedMessage> next_of_bag();
  std::optional<RosRecordedMessage> next_of_mcap();
  const RosType* reader_of(std::uint32_t id, const std::string& type, std::string_view definition);
  void report(const std::string& problem);

  std::unique_ptr<Ros1BagReader> bag_;
  std::unique_ptr<McapReader> mcap_;
  std::unique_ptr<McapMessageCursor> cursor_;
  std::optional<McapMessage> current_;
  std::map<std::uint32_t, std::unique_ptr<RosType>> readers_;  // by connection or channel
  std::vector<std::string> problems_;
};

}  // namespace prehend::recording
