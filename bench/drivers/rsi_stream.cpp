// How well the RSI driver keeps its time beside a machine that is busy: an emulated controller
// streams to it, it moves an arm to and fro, and busy loops take every core. The figure is the
// controller's: answers that it did not take. Prints a report; exit code 1 where more than 0.01 %
// were late or a set point jumped.

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

#include "bench/figures.h"
#include "drivers/kuka_rsi/driver/device.h"
#include "drivers/kuka_rsi/emulator/served_controller.h"
#include "prehend/robot/platform.h"

namespace {

using namespace prehend;
using namespace prehend::drivers;
using namespace prehend::drivers::kuka_rsi;

struct Choices {
  double seconds = 60;
  int load = 2, cycle = 12, priority = 40;
  std::string platform = "config/robots/kr5_pg70.yaml", json = {};
};

/// Processes that do nothing, as fast as they can.
class BusyLoops {
 public:
  explicit BusyLoops(int count) {
    for (int i = 0; i < count; ++i) {
      const pid_t pid = ::fork();
      if (pid == 0) {
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (std::atomic<unsigned long> turns = 0;; ++turns) {
        }
      }
      if (pid > 0) pids_.push_back(pid);
    }
  }
  ~BusyLoops() {
    for (const pid_t pid : pids_) {
      ::kill(pid, SIGKILL);
      ::waitpid(pid, nullptr, 0);
    }
  }

 private:
  std::vector<pid_t> pids_;
};

ControllerOptions controller_options(const Limits& limits, int cycle) {
  ControllerOptions options;
  options.cycle = 1e-3 * cycle;
  options.ipoc_step = static_cast<std::uint64_t>(cycle);
  options.answer_time = cycle == 12 ? 0.010 : 0.004;
  options.late_limit = 100;
  for (std::size_t i = 0; i < kAxes; ++i) {
    options.lower[i] = limits.lower(i);
    options.upper[i] = limits.upper(i);
    options.speed[i] = limits.chain().joints()[i].max_velocity;
  }
  return options;
}

/// A1 from where it is to the other side.
std::unique_ptr<Motion> to_and_fro(const Snapshot& now, const Limits& limits, double cycle) {
  simulation::ArmTrajectory trajectory;
  trajectory.has_velocity = trajectory.has_acceleration = true;
  for (const double time : {0.0, 1.5}) {
    simulation::ArmTrajectory::Point point;
    point.time = time;
    point.position = Eigen::Map<const Eigen::Matrix<double, kAxes, 1>>(now.set_point.data());
    if (time > 0) point.position[0] += now.set_point[0] > now.reference[0] ? -1.0 : 1.0;
    point.velocity.setZero(6);
    point.acceleration.setZero(6);
    trajectory.points.push_back(point);
  }
  auto motion = std::make_unique<Motion>();
  motion->ticket = now.ticket + 1;
  motion->tolerance.fill(0.3);
  motion->set_points = set_points_of(trajectory, now.set_point, now.reference, limits, cycle);
  return motion;
}

int stream(const Choices& choices) {
  const BusyLoops loops(choices.load);  // before there are threads
  const robot::Platform platform = robot::read_platform(choices.platform);
  const Limits limits(platform.arm_chain(), {});
  DeviceOptions options;
  options.host = "127.0.0.1";
  {
    const UdpSocket any("127.0.0.1", 0);
    options.port = ntohs(any.here().address.sin_port);
  }
  options.priority = choices.priority;
  options.driver.cycle = 1e-3 * choices.cycle;
  const auto say = [](bool, const std::string& words) { std::printf("%s\n", words.c_str()); };
  Device device(options, limits, say);
  Axes start{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    start[i] = platform.home("home").arm[static_cast<Eigen::Index>(i)];
  }
  SimpleArm arm(start);
  ServedOptions served;
  served.port = options.port;
  served.priority = choices.priority > 0 ? choices.priority + 1 : 0;
  ServedController controller(arm, controller_options(limits, choices.cycle), served,
                              [](const std::string& words) { std::printf("%s\n", words.c_str()); });
  // The kernel begins to stamp datagrams some time after it was asked to.
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const auto counts = [&] {
    return controller.with_controller([](Controller& c) {
      return std::array{c.telegrams(), c.late_in_all()};
    });
  };
  const auto before = counts();
  int motions = 0, reached = 0;
  bool runs = false;
  const Time end = steady_now() + to_time(choices.seconds);
  while (steady_now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const Snapshot now = device.snapshot();
    if (now.state != State::kHolding) continue;
    reached += runs && now.end == Snapshot::End::kReached;
    runs = device.start(to_and_fro(now, limits, options.driver.cycle));
    motions += runs;
  }
  const Snapshot now = device.snapshot();
  const AnswerTimes times = device.answer_times();
  const auto after = counts();
  const std::uint64_t telegrams = after[0] - before[0], late = after[1] - before[1];
  const double step = controller.with_controller([](Controller& c) { return c.largest_step(); });
  const std::string missing = device.missing_real_time();
  std::printf("%.0f s, cycle %d ms, %d busy loops on %u cores; %s\n", choices.seconds,
              choices.cycle, choices.load, std::thread::hardware_concurrency(),
              choices.priority == 0 ? "real-time scheduling not asked for"
              : missing.empty()     ? "real-time scheduling and locked memory granted"
                                    : missing.c_str());
  std::printf("telegrams %llu, answers late for the controller %llu: %.4f %% in time\n",
              static_cast<unsigned long long>(telegrams), static_cast<unsigned long long>(late),
              100.0 * (1 - static_cast<double>(late) / static_cast<double>(telegrams)));
  std::printf("late in the second before: %llu\n", static_cast<unsigned long long>(before[1]));
  std::printf("grid of the emulated controller missed by a cycle or more: %llu times\n",
              static_cast<unsigned long long>(controller.missed_cycles()));
  std::printf("answer times, from a telegram's arrival:");
  for (std::size_t i = 0; i < times.counts.size(); ++i) {
    if (i < AnswerTimes::kBounds.size()) {
      std::printf(" %llu within %g ms,", static_cast<unsigned long long>(times.counts[i]),
                  1e3 * AnswerTimes::kBounds[i]);
    } else {
      std::printf(" %llu beyond; longest %.2f ms\n",
                  static_cast<unsigned long long>(times.counts[i]), 1e3 * times.longest);
    }
  }
  std::printf(
      "motions %d, reached %d; RSI began %llu times; largest step of a set point %.3f of "
      "what an axis may do in a cycle\n",
      motions, reached, static_cast<unsigned long long>(now.sessions), step);
  const bool is_good = static_cast<double>(late) <= 1e-4 * static_cast<double>(telegrams) &&
                       step <= 1.001 && now.sessions == 1 && reached > 0;
  std::printf("%s\n", is_good ? "good" : "not good");
  bench::Figures figures;
  figures.add("rsi_stream", {{"seconds", choices.seconds},
                             {"telegrams", telegrams},
                             {"late", late},
                             {"longest_answer_ms", 1e3 * times.longest},
                             {"largest_step", step}});
  figures.write(choices.json);
  return is_good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Choices choices;
  CLI::App app{"The RSI driver on a busy machine, against an emulated controller"};
  app.add_option("--seconds", choices.seconds, "How long")->capture_default_str();
  app.add_option("--load", choices.load, "Busy loops beside it")->capture_default_str();
  app.add_option("--cycle", choices.cycle, "Of the controller [ms]")
      ->check(CLI::IsMember({12, 4}))
      ->capture_default_str();
  app.add_option("--priority", choices.priority, "Of real-time scheduling; 0: not asked for")
      ->capture_default_str();
  app.add_option("--json", choices.json, "File for the figures, too");
  CLI11_PARSE(app, argc, argv);
  try {
    return stream(choices);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
