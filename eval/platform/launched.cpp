#include "eval/platform/launched.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

constexpr int kNotStarted = 127;  // as shells have it

// Of `prehend launch launch/demo.yaml` for a platform in a scene's file, as fast as it can.
std::vector<std::string> demo_words(const std::filesystem::path& scene, const std::string& platform,
                                    const std::filesystem::path& folder,
                                    const std::vector<std::string>& arguments) {
  const std::filesystem::path out = std::filesystem::absolute(folder);
  std::vector<std::string> words{"launch",
                                 text::tree_file("launch/demo.yaml"),
                                 "platform:=" + platform,
                                 "scene:=" + std::filesystem::absolute(scene).string(),
                                 "out:=" + out.string(),
                                 "speed:=0",
                                 "record:=true",
                                 "--log-dir",
                                 (out / "log").string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

}  // namespace

using std::chrono::steady_clock;

int run_prehend(const std::filesystem::path& programs, const std::vector<std::string>& arguments,
                const std::filesystem::path& log, std::chrono::seconds timeout) {
  const std::filesystem::path program = programs / "prehend";
  std::vector<char*> words;
  words.push_back(const_cast<char*>(program.c_str()));
  for (const std::string& argument : arguments) {
    words.push_back(const_cast<char*>(argument.c_str()));
  }
  words.push_back(nullptr);
  const int output = open(log.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0644);
  if (output < 0) {
    throw std::runtime_error("cannot write " + log.string() + ": " + std::strerror(errno));
  }
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGINT);  // what runs ends with whom it runs for
    if (getppid() != parent || dup2(output, STDOUT_FILENO) < 0 || dup2(output, STDERR_FILENO) < 0) {
      _exit(kNotStarted);
    }
    execv(program.c_str(), words.data());
    dprintf(STDERR_FILENO, "cannot start %s: %s\n", program.c_str(), std::strerror(errno));
    _exit(kNotStarted);
  }
  const int why = errno;
  close(output);
  if (pid < 0) throw std::system_error(why, std::generic_category(), "fork");
  const auto deadline = steady_clock::now() + timeout;
  int status = 0;
  while (waitpid(pid, &status, WNOHANG) == 0) {
    if (steady_clock::now() > deadline) {
      kill(pid, SIGINT);  // it stops its nodes
      waitpid(pid, &status, 0);
      return -1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int run_demo(const std::filesystem::path& programs, const std::filesystem::path& scene,
             const std::string& platform, const std::filesystem::path& folder,
             const std::vector<std::string>& arguments, std::chrono::seconds timeout) {
  const std::filesystem::path said = folder / "output.txt";
  const int code =
      run_prehend(programs, demo_words(scene, platform, folder, arguments), said, timeout);
  if (std::filesystem::exists(folder / "recording.mcap")) return code;
  std::string last = "nothing";
  std::ifstream lines(said);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) last = line;
  }
  throw geometry::InputError("launch/demo.yaml left no recording; it said last: " + last,
                             "See " + said.string());
}

std::vector<std::string> launch_arguments(const std::vector<std::string>& words) {
  constexpr const char* kOwn[] = {"platform", "scene", "out", "speed", "record"};
  for (const std::string& word : words) {
    const std::size_t at = word.find(":=");
    if (at == 0 || at == std::string::npos) {
      throw geometry::InputError("The launch argument '" + word + "' is not NAME:=VALUE",
                                 "Write e.g. minimum_stability:=0.1");
    }
    const std::string name = word.substr(0, at);
    if (std::find(std::begin(kOwn), std::end(kOwn), name) != std::end(kOwn)) {
      throw geometry::InputError("The launch argument '" + name + "' is given by the evaluation",
                                 "Leave it out; --platform and --out choose theirs");
    }
  }
  return words;
}

}  // namespace prehend::eval
