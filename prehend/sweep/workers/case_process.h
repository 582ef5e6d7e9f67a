#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "prehend/sweep/results.h"

namespace prehend::sweep {

/// What a worker is told to run.
struct CaseOrder {
  std::int64_t index = 0;
  std::string name;
  std::vector<std::string> words;  // of run_program(): the program's path and its arguments
  std::string folder;              // its own; it is emptied first
  ResultSource results;
  double timeout = 0;  // s; 0: none
  bool keep = true;    // the folder, when all went well
};

/// What became of it: its result, or none when it was ended from outside (SIGKILL as where memory
/// ended, SIGTERM, SIGINT, SIGHUP), which says nothing of the case.
struct CaseEnd {
  std::int64_t index = 0;
  std::optional<CaseResult> result;
};

/// What the process of a case does. The case is well when it returns; what it throws is printed.
using CaseBody = std::function<void(const CaseOrder&)>;

/// Becomes the program that the order's words name, with this process's environment but for what
/// makes it a rank of MPI; a program that uses MPI itself would take itself for one of ours.
[[noreturn]] void run_program(const CaseOrder& order);

/// One case as a child process in a group of its own, with what it prints in FOLDER/output.txt. It
/// dies with this process.
class CaseProcess {
 public:
  /// @pre What other threads of this process lock, `body` does not use (memory excepted).
  /// @throws InputError when the folder cannot be made, std::system_error for want of processes.
  CaseProcess(CaseOrder order, const CaseBody& body);
  /// Ends it: SIGTERM, 3 s later SIGKILL.
  ~CaseProcess();
  CaseProcess(const CaseProcess&) = delete;
  CaseProcess& operator=(const CaseProcess&) = delete;

  /// Its end, once it is there; ends it when it takes longer than its timeout.
  std::optional<CaseEnd> poll();
  /// When poll() has something to do even if no child ends: the timeout. [s], none: infinite.
  double seconds_left() const;
  /// Asks it to end; for a process that is destroyed soon.
  void ask_to_end() const;

 private:
  CaseEnd ended(int status);
  double seconds() const;
  bool has_ended() const;

  CaseOrder order_;
  std::filesystem::path output_;
  pid_t process_ = -1;
  std::chrono::steady_clock::time_point start_;
  bool is_late_ = false, is_killed_ = false;
};

/// SIGCHLD, SIGINT, SIGTERM and SIGHUP wait for wait_for_signal() from now on, in this process and
/// not in the children that CaseProcess makes.
void hold_signals();
/// Waits for one of them, `seconds` at most. True when this process is to end.
bool wait_for_signal(double seconds);

/// "host:process", for the costs.
std::string this_worker();

}  // namespace prehend::sweep
