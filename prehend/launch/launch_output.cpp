#include "prehend/launch/launch_output.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <stdexcept>

namespace prehend::launch {
namespace {

constexpr const char* kReset = "\x1b[0m";
constexpr const char* kOwnName = "launch";
constexpr std::array kNameColors{"\x1b[36m", "\x1b[35m", "\x1b[34m", "\x1b[32m",
                                 "\x1b[33m", "\x1b[96m", "\x1b[95m", "\x1b[94m"};

}  // namespace

LaunchOutput::LaunchOutput(const std::string& log_folder, const std::vector<std::string>& names)
    : folder_(log_folder),
      use_color_(::isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error)
    throw std::runtime_error("cannot make the log folder " + folder_ + ": " + error.message());
  width_ = std::strlen(kOwnName);
  for (std::size_t i = 0; i < names.size(); ++i) {
    width_ = std::max(width_, names[i].size());
    positions_[names[i]] = i;
  }
}

std::FILE* LaunchOutput::log_of(const std::string& name) {
  File& log = logs_[name];
  if (!log) {
    const std::string path = folder_ + "/" + name + ".log";
    log.reset(std::fopen(path.c_str(), "we"));
    if (!log) throw std::runtime_error("cannot write " + path + ": " + std::strerror(errno));
  }
  return log.get();
}

void LaunchOutput::process_line(const std::string& name, std::string_view line) {
  const std::size_t position = positions_.count(name) > 0 ? positions_.at(name) : 0;
  show(name, kNameColors[position % kNameColors.size()], "", line);
}

void LaunchOutput::own_line(const char* color, std::string_view kind, std::string_view text) {
  show(kOwnName, "\x1b[1m", color, std::string(kind) + std::string(text));
}

void LaunchOutput::show(const std::string& name, const char* name_color, const char* text_color,
                        std::string_view text) {
  const int length = static_cast<int>(text.size());
  const int padding = static_cast<int>(width_ - std::min(width_, name.size()));
  if (use_color_) {
    std::printf("%s%s%*s │%s ", name_color, name.c_str(), padding, "", kReset);
    std::printf("%s%.*s%s\n", text_color, length, text.data(), kReset);
  } else {
    std::printf("%s%*s | %.*s\n", name.c_str(), padding, "", length, text.data());
  }
  std::fflush(stdout);
  std::FILE* log = log_of(name);
  std::fprintf(log, "%.*s\n", length, text.data());
  std::fflush(log);
}

std::string new_log_folder() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  ::localtime_r(&now, &local);
  std::array<char, 32> stamp{};
  std::strftime(stamp.data(), stamp.size(), "%Y%m%d-%H%M%S", &local);
  const std::string base = std::string("out/log/") + stamp.data();
  std::string folder = base;
  for (int i = 2; std::filesystem::exists(folder); ++i) folder = base + "-" + std::to_string(i);
  return folder;
}

}  // namespace prehend::launch
