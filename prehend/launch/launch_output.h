#pragma once

#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace prehend::launch {

/// What a launch shows: every line of every process with the process' name before it, in colour on
/// a terminal (unless NO_COLOR is set), and the same lines in one log file for each process.
class LaunchOutput {
 public:
  /// `log_folder` is created; throws std::runtime_error when it cannot be. `names`: of the
  /// processes, for alignment.
  LaunchOutput(const std::string& log_folder, const std::vector<std::string>& names);

  /// One line of a process.
  void process_line(const std::string& name, std::string_view line);
  /// Lines of the launch itself: progress, a success, a warning, an error.
  void progress(std::string_view text) { own_line("", text); }
  void success(std::string_view text) { own_line("\x1b[32m", text); }
  void warning(std::string_view text) { own_line("\x1b[33m", "warning: ", text); }
  void error(std::string_view text) { own_line("\x1b[1;31m", "error: ", text); }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  using File = std::unique_ptr<std::FILE, Closer>;

  void own_line(const char* color, std::string_view text) { own_line(color, "", text); }
  void own_line(const char* color, std::string_view kind, std::string_view text);
  void show(const std::string& name, const char* name_color, const char* text_color,
            std::string_view text);
  std::FILE* log_of(const std::string& name);

  const std::string folder_;
  const bool use_color_;
  std::size_t width_ = 0;
  std::map<std::string, std::size_t> positions_;  // of names, for their colours
  std::map<std::string, File> logs_;
};

/// A new folder name out/log/DATE-TIME below the working directory.
std::string new_log_folder();

}  // namespace prehend::launch
