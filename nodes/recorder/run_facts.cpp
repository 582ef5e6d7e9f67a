#include "nodes/recorder/run_facts.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace prehend {
namespace {

std::string file_content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The process' words, quoted where they have spaces.
std::string command_line() {
  std::string text, word;
  for (const char c : file_content("/proc/self/cmdline")) {
    if (c != '\0') {
      word += c;
      continue;
    }
    const bool plain = !word.empty() && word.find_first_of(" \t\"'") == std::string::npos;
    if (!text.empty()) text += ' ';
    text += plain ? word : fmt::format("'{}'", word);
    word.clear();
  }
  return text;
}

// First line of what the shell command prints; empty when it fails.
std::string first_line_of(const char* command) {
  FILE* pipe = ::popen(command, "r");
  if (pipe == nullptr) return "";
  std::array<char, 256> line{};
  const bool got = std::fgets(line.data(), line.size(), pipe) != nullptr;
  const bool succeeded = ::pclose(pipe) == 0;
  std::string text = got && succeeded ? line.data() : "";
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 64> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

const char* media_type_of(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".yaml" || extension == ".yml") return "text/yaml";
  if (extension == ".json") return "application/json";
  if (extension == ".txt" || extension == ".log") return "text/plain";
  return "application/octet-stream";
}

}  // namespace

recording::McapMetadata run_facts() {
  recording::McapMetadata facts{kRunMetadata, {}};
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0) facts.entries["host"] = host.data();
  std::error_code error;
  facts.entries["working_directory"] = std::filesystem::current_path(error).string();
  facts.entries["command_line"] = command_line();
  facts.entries["started"] = utc_now();
  const std::string revision = first_line_of(
      "timeout 2 git describe --always --dirty --abbrev=40 --exclude '*' 2>/dev/null");
  if (!revision.empty()) facts.entries["git_revision"] = revision;
  return facts;
}

recording::McapAttachment attachment_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    throw std::runtime_error("cannot read the attachment " + path + ": " + std::strerror(errno));
  }
  std::ifstream file(path, std::ios::binary);
  if (!S_ISREG(status.st_mode) || !file) {
    throw std::runtime_error("cannot read the attachment " + path + ": it is no readable file");
  }
  recording::McapAttachment attachment;
  attachment.name = std::filesystem::path(path).filename().string();
  attachment.media_type = media_type_of(path);
  attachment.data.assign(std::istreambuf_iterator<char>(file), {});
  attachment.create_time = static_cast<std::uint64_t>(status.st_mtim.tv_sec) * 1000000000u +
                           static_cast<std::uint64_t>(status.st_mtim.tv_nsec);
  return attachment;
}

}  // namespace prehend
