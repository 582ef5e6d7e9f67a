#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"
#include "prehend/recording/topic_filter.h"

namespace prehend::tools {

/// Writes parts of a recording to a new one, which has its name only once it is whole.
class RecordingCopy {
 public:
  /// @throws std::runtime_error for a file that exists, recording::McapError for one that cannot be
  /// written.
  RecordingCopy(recording::McapReader& reader, const std::string& to,
                const recording::McapWriterOptions& options);
  /// What is not finished is removed.
  ~RecordingCopy();
  RecordingCopy(const RecordingCopy&) = delete;
  RecordingCopy& operator=(const RecordingCopy&) = delete;

  void declare(const recording::TopicFilter& filter);
  void copy_attachments();
  void write(const recording::McapMessage& message, std::uint64_t log_time);
  void copy_messages(const recording::McapMessageFilter& filter);
  recording::McapWriter& writer() { return writer_; }
  /// Prints what was skipped. Returns the number of messages written.
  std::uint64_t finish();

 private:
  recording::McapReader& reader_;
  const std::string path_;
  recording::McapWriter writer_;
  std::map<std::uint16_t, std::uint16_t> channels_;  // written, by that read
  bool finished_ = false;
};

}  // namespace prehend::tools
