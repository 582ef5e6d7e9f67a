#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace prehend::recording {

/// What check_recording() found.
struct RecordingCheck {
  std::vector<std::string> problems;   ///< one line each, with its place; empty: all is well
  std::uint64_t further_problems = 0;  ///< that are not listed
  /// What its writer put under no checksum, so that damage there may not be seen; empty for
  /// recordings of this project.
  std::vector<std::string> notes;
  std::uint64_t messages = 0;  ///< read
  std::uint64_t chunks = 0;
  std::uint64_t attachments = 0;
};

/// Verifies a whole recording: every checksum (chunks, attachments, data section, summary), that
/// each record can be read, that indexes, statistics and summary say what is there, that times of a
/// channel do not go back and lie within their chunk's, that schemas can be used and all protobuf
/// messages decode. In a recording that has all checksums any change of a single byte is found.
/// Reads every byte once. Throws McapError when the file cannot be opened or is no
/// MCAP file.
RecordingCheck check_recording(const std::string& path);

}  // namespace prehend::recording
