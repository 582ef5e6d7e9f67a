#include "tools/sweep/case_program.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "prehend/text/input_error.h"
#include "tools/programs.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using text::InputError;

bool is_program(const fs::path& file) {
  return fs::is_regular_file(file) && access(file.c_str(), X_OK) == 0;
}

struct PipeCloser {
  void operator()(std::FILE* pipe) const { pclose(pipe); }
};

}  // namespace

std::string shell_word(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string case_program(const std::string& program) {
  if (program.find('/') != std::string::npos) {
    if (is_program(program)) return fs::absolute(program).string();
    throw InputError("There is no program '" + program + "'",
                     "Check the path, which begins where the sweep is started");
  }
  const char* path = std::getenv("PATH");
  std::istringstream folders(program_folder() + ":" + (path ? path : ""));
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (!folder.empty() && is_program(fs::path(folder) / program)) {
      return fs::absolute(fs::path(folder) / program).string();
    }
  }
  throw InputError("There is no program '" + program + "' beside prehend or on PATH",
                   "Check the name, or write its path");
}

std::vector<std::string> lines_of(const std::vector<std::string>& words) {
  std::string command = "exec " + shell_word(case_program(words.front()));
  for (std::size_t i = 1; i < words.size(); ++i) command += " " + shell_word(words[i]);
  std::unique_ptr<std::FILE, PipeCloser> pipe(popen(command.c_str(), "re"));
  if (!pipe) throw InputError("'" + words.front() + "' cannot be started", "Try it by hand");
  std::string printed;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) {
    printed += static_cast<char>(c);
  }
  const int status = pclose(pipe.release());
  if (status != 0 || printed.empty()) {
    throw InputError("'" + words.front() + "' " + (status != 0 ? "failed" : "printed nothing") +
                         " when it was asked for values",
                     "Try it by hand");
  }
  std::vector<std::string> lines;
  std::istringstream in(printed);
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

}  // namespace prehend::tools
