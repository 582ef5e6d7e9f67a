#include "prehend/sweep/workers/said_progress.h"

#include <unistd.h>

#include <cstdio>
#include <string>

#include <fmt/format.h>

namespace prehend::sweep {
namespace {

constexpr double kBetween = 30;  // s, of lines in a log

bool is_terminal() { return isatty(STDERR_FILENO) != 0; }

std::string duration(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

void SaidProgress::say(const RunProgress& progress) {
  if (!is_terminal() && progress.seconds - last_ < kBetween) return;
  last_ = progress.seconds;
  const std::int64_t ended = progress.done + progress.failed;
  std::string left;
  if (ended > 0) {
    const double rate = static_cast<double>(ended) / progress.seconds;
    left = ", about " + duration(static_cast<double>(progress.total - ended) / rate) + " left";
  }
  fmt::print(stderr, "{}{} of {} done, {} failed{}{}", is_terminal() ? "\r" : "", progress.done,
             progress.total, progress.failed, left, is_terminal() ? "   " : "\n");
  std::fflush(stderr);
}

void SaidProgress::end() const {
  if (is_terminal()) fmt::print(stderr, "\r{:79}\r", "");
}

void print_summary(const RunProgress& progress) {
  const std::int64_t ended = progress.done + progress.failed;
  fmt::print("{} of {} cases ran in {:.1f} s with {} workers: {} done, {} failed\n", ended,
             progress.total, progress.seconds, progress.workers, progress.done, progress.failed);
  if (ended == 0) return;
  fmt::print("A case took {:.3f} s, handing it out {:.1f} ms, {:.2f} % of that\n",
             progress.working / static_cast<double>(ended),
             1e3 * progress.waiting / static_cast<double>(ended),
             100 * progress.waiting / progress.working);
}

}  // namespace prehend::sweep
