#include "tests/system/launched.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace prehend::testing {
namespace {

std::filesystem::path program_folder() {
  const char* folder = std::getenv("PREHEND_BIN");
  return folder != nullptr ? folder : "build/bin";
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

pid_t parent_of(pid_t pid) {
  const std::string stat = read_file("/proc/" + std::to_string(pid) + "/stat");
  const auto name_end = stat.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream fields(stat.substr(name_end + 1));
  std::string state;
  pid_t parent = 0;
  fields >> state >> parent;
  return parent;
}

}  // namespace

ScratchFolder::ScratchFolder() {
  std::string pattern = std::filesystem::temp_directory_path() / "prehend-system-XXXXXX";
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make a scratch folder");
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // left-overs in /tmp must not fail a test
  std::filesystem::remove_all(path_, ignored);
}

Launched::Launched(const std::string& program, const std::vector<std::string>& arguments,
                   const std::filesystem::path& output_file)
    : output_file_(output_file) {
  const std::string executable = program_folder() / program;
  std::vector<char*> argv;
  argv.push_back(const_cast<char*>(executable.c_str()));
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const int output = open(output_file.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0600);
  if (output < 0) throw std::runtime_error("cannot write " + output_file.string());
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // nothing outlives the test
    setpgid(0, 0);
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
    execv(executable.c_str(), argv.data());
    _exit(127);
  }
  close(output);
  if (pid_ < 0) throw std::runtime_error("fork failed");
}

Launched::~Launched() {
  if (exit_code_) return;
  // A launch stops its children when it is interrupted; only then is it killed.
  kill(pid_, SIGINT);
  if (!wait(std::chrono::seconds(10))) {
    kill(-pid_, SIGKILL);
    wait(std::chrono::seconds(5));
  }
}

bool Launched::has_ended() {
  if (exit_code_) return true;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return true;
}

std::optional<int> Launched::wait(std::chrono::seconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!has_ended() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return exit_code_;
}

std::string Launched::output() const { return read_file(output_file_); }

bool Launched::wait_for_output(const std::string& text, std::chrono::seconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (std::chrono::steady_clock::now() < deadline) {
    const bool ended = has_ended();
    if (output().find(text) != std::string::npos) return true;
    if (ended) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

void Launched::send_signal(int signal) { kill(pid_, signal); }

Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                    std::chrono::seconds timeout) {
  const ScratchFolder scratch;
  Launched launched(program, arguments, scratch.path() / "output");
  const auto exit_code = launched.wait(timeout);
  return {exit_code, launched.output()};
}

std::vector<pid_t> descendants(pid_t pid, const std::string& program) {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const pid_t candidate = std::stoi(name);
    pid_t ancestor = parent_of(candidate);
    while (ancestor > 1 && ancestor != pid) ancestor = parent_of(ancestor);
    if (ancestor != pid) continue;
    std::error_code gone;  // a process may end while it is looked at
    const auto executable = std::filesystem::read_symlink(entry.path() / "exe", gone);
    if (!gone && executable.filename() == program) found.push_back(candidate);
  }
  return found;
}

}  // namespace prehend::testing
