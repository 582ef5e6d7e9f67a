#pragma once

#include <unistd.h>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"

namespace prehend::recording {

/// A folder of its own that vanishes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "prehend_test_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_file(const std::string& path, const std::string& bytes) {
  std::filesystem::remove(path);  // ext4 flushes a file that is truncated and written again
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::vector<McapMessage> all_messages(McapReader& reader,
                                             const McapMessageFilter& filter = {}) {
  std::vector<McapMessage> messages;
  McapMessageCursor cursor = reader.messages(filter);
  while (auto message = cursor.next()) messages.push_back(*message);
  return messages;
}

/// The schema of the format's worked example: message t.P { double x = 1; }.
inline std::string example_schema() {
  using namespace std::string_literals;
  return "\x0a\x27\x0a\x07t."
         "proto\x12\x01t\x22\x11\x0a\x01P\x12\x0c\x0a\x01x\x18\x01\x20\x01\x28\x01"
         "R\x01xb\x06proto3"s;
}

}  // namespace prehend::recording
