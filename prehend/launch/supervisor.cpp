#include "prehend/launch/supervisor.h"

#include <fmt/core.h>
#include <signal.h>
#include <string.h>

#include <sys/wait.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "prehend/graph/node_program.h"
#include "prehend/launch/deaths.h"
#include "prehend/launch/launch_events.h"
#include "prehend/launch/launch_registry.h"
#include "prehend/launch/process_plan.h"
#include "prehend/launch/readiness.h"
#include "prehend/launch/stop_schedule.h"

namespace prehend::launch {
namespace {

using Clock = SupervisedProcess::Clock;
using std::chrono::milliseconds;
using Seconds = std::chrono::duration<double>;

constexpr milliseconds kReadyPoll{50};  // between questions to the registry
// Of a respawned process in a row, before it was ready: starting it again does not mend a wrong
// configuration. As StartLimitBurst of systemd.unit(5).
constexpr int kMostFailedStarts = 5;

double seconds_since(Clock::time_point start) { return Seconds(Clock::now() - start).count(); }

bool answers_no(int status) {
  return WIFEXITED(status) && WEXITSTATUS(status) == graph::kAnswerIsNo;
}

// A program that has no handler for SIGINT and ends by it did what it was asked to, and one that
// has found a no has found it.
bool ended_as_asked(int status) {
  return is_success(status) || answers_no(status) ||
         (WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
}

std::vector<std::string> names_of(const std::vector<LaunchProcess>& processes) {
  std::vector<std::string> names{"registry"};
  for (const LaunchProcess& process : processes) names.push_back(process.name);
  return names;
}

class Supervisor {
 public:
  Supervisor(const LaunchGraph& graph, const SupervisorOptions& options)
      : graph_(graph),
        options_(options),
        plan_(processes_of(graph, options.host)),
        output_(options.log_folder, names_of(plan_)),
        registry_(options_, signals_, output_) {}

  int run() {
    output_.progress(fmt::format("{}{}: {}, logs in {}", graph_.file,
                                 options_.host.empty() ? "" : " on " + options_.host, nodes_text(),
                                 options_.log_folder));
    for (const std::string& warning : graph_.warnings) output_.warning(warning);
    if (const int signal = registry_.start()) stop_for(signal);
    if (!exit_code_) prepare();
    while (!exit_code_) step();
    stop_all();
    return deaths_.any_for_good() ? 1 : *exit_code_;
  }

 private:
  struct Member {
    const LaunchProcess* plan;
    SupervisedProcess process;
    std::optional<StopSchedule> stop;  // since it was asked to stop
    bool was_killed = false;           // by this launch, as it did not stop
  };

  std::string nodes_text() const {
    std::size_t count = 0;
    for (const LaunchProcess& process : plan_) count += process.nodes.size();
    std::string text = std::to_string(count) + (count == 1 ? " node" : " nodes");
    if (count != plan_.size()) {
      text +=
          " in " + std::to_string(plan_.size()) + (plan_.size() == 1 ? " process" : " processes");
    }
    return text;
  }

  // --- running -----------------------------------------------------------------------------------

  void prepare() {
    for (const LaunchProcess& plan : plan_) {
      std::map<std::string, std::string> environment = plan.environment;
      environment["PREHEND_REGISTRY"] = registry_.endpoint();
      environment["PREHEND_LAUNCH_FILE"] = graph_.file;  // a recorder keeps it
      members_.push_back(std::make_unique<Member>(Member{
          &plan, SupervisedProcess(plan.name, plan.command, environment, plan.share, output_),
          std::nullopt, false}));
    }
    begun_ = Clock::now();
    readiness_ = std::make_unique<Readiness>(registry_.endpoint());
    start_due();
  }

  std::vector<SupervisedProcess*> all_processes() {
    std::vector<SupervisedProcess*> processes;
    if (registry_.process()) processes.push_back(registry_.process());
    for (const auto& member : members_) processes.push_back(&member->process);
    return processes;
  }

  void step() {
    auto deadline = Clock::now() + (some_get_ready() ? kReadyPoll : milliseconds(1000));
    const auto processes = all_processes();
    for (SupervisedProcess* process : processes) {
      if (process->restart_at) deadline = std::min(deadline, *process->restart_at);
    }
    wait_for_events(signals_, processes, deadline);
    if (const int signal = signals_.take_stop()) stop_for(signal);
    for (SupervisedProcess* process : processes) process->forward_output();
    if (some_get_ready() && !exit_code_) look_for_readiness();
    for (const auto& member : members_) {
      if (const auto status = member->process.reap()) ended(*member, *status);
    }
    if (exit_code_) return;
    if (const int signal = registry_.keep_alive()) return stop_for(signal);
    start_due();
    const bool some_wanted = std::any_of(members_.begin(), members_.end(), [](const auto& member) {
      return member->process.is_wanted();
    });
    if (some_wanted) return;
    output_.progress("all nodes have ended");
    exit_code_ = 0;
  }

  void start_due() {
    for (const auto& member : members_) {
      SupervisedProcess& process = member->process;
      const bool due = process.was_started()
                           ? process.restart_at && *process.restart_at <= Clock::now()
                           : awaited(*member->plan).empty();
      if (due) process.start();
    }
  }

  // The first node that the process has to wait for; "" when it may start.
  std::string awaited(const LaunchProcess& plan) const {
    for (const std::string& node : plan.after) {
      const Member* member = member_with(node);
      const bool fulfilled =
          member ? member->process.ready || member->process.succeeded : readiness_->is_ready(node);
      if (!fulfilled) return node;
    }
    return "";
  }

  const Member* member_with(const std::string& node) const {
    for (const auto& member : members_) {
      for (const LaunchNode* own : member->plan->nodes) {
        if (own->name == node) return member.get();
      }
    }
    return nullptr;
  }

  // What follows from a process' end while the launch is running or stopping.
  void ended(Member& member, int status) {
    SupervisedProcess& process = member.process;
    const std::string words = process.name() + ": " + describe_status(status);
    if (exit_code_) return ended_while_stopping(member, status);
    const bool is_answer = member.plan->required && answers_no(status);
    if (is_success(status) || is_answer) {
      deaths_.forgive(process.name());
    } else {
      deaths_.add(process.name(), describe_status(status), Clock::now() - begun_);
    }
    const std::string last =
        process.last_line().empty() ? "" : "; it said last: " + process.last_line();
    if (member.plan->required) {
      if (is_success(status)) {
        output_.success(process.name() + " finished");
        exit_code_ = 0;
      } else if (is_answer) {
        output_.warning(process.name() + " finished, and its answer is no" + last);
        exit_code_ = graph::kAnswerIsNo;
      } else {
        output_.error("required node " + words + last);
        exit_code_ = 1;
      }
    } else if (member.plan->respawn.wanted && may_start_again(process, status)) {
      plan_restart(member, words);
    } else if (member.plan->respawn.wanted && refuses_input(process, status)) {
      output_.error("node " + words + last +
                    "; it refuses what it is given and is not started again");
      if (!process.was_ready) exit_code_ = 1;
    } else if (member.plan->respawn.wanted) {
      give_up(process, words, last);
    } else if (is_success(status)) {
      output_.progress(process.name() + " finished");
    } else if (!process.ready) {
      output_.error("node " + words + " before it was ready" + last);
      exit_code_ = 1;
    } else {
      output_.error("node " + words + last + "; the others go on without it");
    }
  }

  bool may_start_again(SupervisedProcess& process, int status) const {
    const bool is_failed_start = !process.ready && !is_success(status);
    process.failed_starts = is_failed_start ? process.failed_starts + 1 : 0;
    return process.failed_starts < kMostFailedStarts && !refuses_input(process, status);
  }

  static bool refuses_input(const SupervisedProcess& process, int status) {
    return !process.ready && WIFEXITED(status) && WEXITSTATUS(status) == graph::kWrongInput;
  }

  // One that has been ready in this launch is done without; else the launch is not what was asked
  // for.
  void give_up(const SupervisedProcess& process, const std::string& words,
               const std::string& last) {
    const std::string text = fmt::format("node {}, {} times in a row before it was ready{}", words,
                                         process.failed_starts, last);
    if (process.was_ready) {
      output_.error(text + "; it is given up, and the others go on without it");
      return;
    }
    output_.error(text + "; it is given up");
    exit_code_ = 1;
  }

  void plan_restart(Member& member, const std::string& words) {
    SupervisedProcess& process = member.process;
    const Respawn& respawn = member.plan->respawn;
    const bool was_steady = Clock::now() - process.started() >= options_.steady_time;
    const bool is_first = was_steady || process.delay == Seconds(0);
    process.delay = is_first ? Seconds(respawn.first_delay)
                             : std::min(Seconds(respawn.longest_delay), 2 * process.delay);
    process.restart_at = Clock::now() + std::chrono::duration_cast<Clock::duration>(process.delay);
    output_.warning(fmt::format("{}; starting it again in {:.1f} s", words, process.delay.count()));
  }

  // --- readiness ---------------------------------------------------------------------------------

  bool some_get_ready() const {
    return !all_ready_ || std::any_of(members_.begin(), members_.end(), [](const auto& member) {
      return member->process.running() && !member->process.ready;
    });
  }

  void look_for_readiness() {
    if (!readiness_->ask()) return;
    std::size_t ready_count = 0;
    for (const auto& member : members_) {
      SupervisedProcess& process = member->process;
      if (!process.ready && process.running()) {
        process.ready = readiness_->is_ready(*member->plan, process.child()->pid());
        process.was_ready |= process.ready;
      }
      ready_count += process.ready || !process.is_wanted() ? 1 : 0;
    }
    if (all_ready_) return;
    if (ready_count == members_.size()) {
      all_ready_ = true;
      output_.success(fmt::format("{} ready after {:.1f} s", nodes_text(), seconds_since(begun_)));
      for (const LaunchProcess& process : plan_) {
        for (const LaunchNode* node : process.nodes) readiness_->check_remaps(*node, output_);
      }
    } else if (!late_named_ && Clock::now() - begun_ > options_.ready_timeout) {
      late_named_ = true;
      name_late_ones();
    }
  }

  void name_late_ones() {
    for (const auto& member : members_) {
      if (!member->process.was_started()) {
        output_.warning(member->plan->name + " waits for " + awaited(*member->plan));
      } else if (!member->process.ready) {
        output_.warning(member->plan->name + " is still not ready");
      }
    }
  }

  // --- stopping ----------------------------------------------------------------------------------

  void stop_for(int signal) {
    if (exit_code_) return;
    output_.progress(std::string("SIG") + ::sigabbrev_np(signal) + ": stopping all nodes");
    exit_code_ = 0;
  }

  StopTimes stop_times_of(const LaunchProcess& plan) const {
    if (!plan.stop_time) {
      return {options_.interrupt_time, options_.terminate_time, options_.hurried_time};
    }
    const milliseconds own(static_cast<std::int64_t>(*plan.stop_time * 1e3));
    return {own, options_.terminate_time, own};
  }

  // SIGINT to all that run; those that died before and were started again lived to the end.
  void ask_to_stop(Clock::time_point now) {
    for (const auto& member : members_) {
      if (!member->process.running()) continue;
      deaths_.forgive(member->process.name());
      member->stop.emplace(stop_times_of(*member->plan), now);
      member->process.child()->send_signal(SIGINT);
    }
  }

  void hurry() {
    if (std::exchange(hurry_, true)) return;
    std::string patient;
    for (const auto& member : members_) {
      if (!member->process.running()) continue;
      member->stop->hurry();
      if (!member->plan->stop_time) continue;
      patient += fmt::format("; {} has {:g} s, to write what it has", member->plan->name,
                             *member->plan->stop_time);
    }
    output_.warning(fmt::format("a second signal: what still runs is killed {:g} s after the first",
                                Seconds(options_.hurried_time).count()) +
                    patient);
  }

  // Sends what is due; returns when something will be next.
  Clock::time_point press_on() {
    const auto now = Clock::now();
    auto next = now + options_.terminate_time;
    for (const auto& member : members_) {
      if (!member->process.running()) continue;
      if (const auto signal = member->stop->take_due(now)) {
        output_.warning(fmt::format("{} does not stop: sending SIG{}", member->plan->name,
                                    ::sigabbrev_np(*signal)));
        member->was_killed |= *signal == SIGKILL;
        member->process.child()->send_signal(*signal);
      }
      if (const auto step = member->stop->next()) next = std::min(next, step->when);
    }
    return next;
  }

  bool any_hope() const {
    return std::any_of(members_.begin(), members_.end(), [](const auto& member) {
      return member->process.running() && !member->stop->is_hopeless(Clock::now());
    });
  }

  void ended_while_stopping(Member& member, int status) {
    if (ended_as_asked(status)) return;
    std::string how = describe_status(status);
    if (member.was_killed) {
      how = "killed, as it did not stop when asked to";
    } else if (member.stop) {
      how += " when asked to stop";
    }
    output_.progress(member.process.name() + ": " + how);
    deaths_.add(member.process.name(), how, Clock::now() - begun_);
  }

  void stop_all() {
    const auto start = Clock::now();
    ask_to_stop(start);
    while (any_hope()) {
      const auto next = press_on();
      const auto processes = all_processes();
      wait_for_events(signals_, processes, next);
      if (signals_.take_stop() != 0) hurry();
      for (SupervisedProcess* process : processes) process->forward_output();
      for (const auto& member : members_) {
        if (const auto status = member->process.reap()) ended(*member, *status);
      }
    }
    if (!registry_.stop()) {
      deaths_.add("registry", "killed, as it did not stop when asked to", Clock::now() - begun_);
    }
    if (!members_.empty()) sum_up(start);
  }

  void sum_up(Clock::time_point stop_begun) {
    std::string memory;
    for (const auto& member : members_) {
      memory += fmt::format("{}{} {:.0f}", memory.empty() ? "" : ", ", member->plan->name,
                            static_cast<double>(member->process.peak_memory()) * 1e-6);
    }
    output_.progress("peak memory [MB]: " + memory);
    output_.progress(fmt::format("all stopped after {:.1f} s", seconds_since(stop_begun)));
    for (const Deaths::Line& line : deaths_.lines()) {
      line.for_good ? output_.error(line.text) : output_.warning(line.text);
    }
  }

  const LaunchGraph& graph_;
  const SupervisorOptions options_;
  const SignalSource signals_;  // early: threads made later inherit the blocked signals
  const std::vector<LaunchProcess> plan_;
  LaunchOutput output_;
  LaunchRegistry registry_;
  std::vector<std::unique_ptr<Member>> members_;
  std::unique_ptr<Readiness> readiness_;
  Clock::time_point begun_ = Clock::now();
  std::optional<int> exit_code_;  // set once the launch is to end
  Deaths deaths_;
  bool all_ready_ = false, late_named_ = false, hurry_ = false;
};

}  // namespace

int run_launch(const LaunchGraph& graph, const SupervisorOptions& options) {
  return Supervisor(graph, options).run();
}

}  // namespace prehend::launch
