#include "prehend/sweep/workers/run_cases.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace prehend::sweep {
namespace {

using Clock = std::chrono::steady_clock;

double between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

RunProgress run_cases(Handout& handout, Workers& workers, ResultStore& store,
                      const std::function<CaseOrder(std::int64_t)>& order,
                      const std::function<void(const RunProgress&)>& say) {
  RunProgress progress;
  progress.total = handout.total();
  const Clock::time_point start = Clock::now();
  Clock::time_point before = start, said = start;
  double occupied = 0;  // s of workers that ran a case, or could have
  int running = 0;
  std::optional<std::int64_t> next = handout.next();
  std::vector<CaseResult> results;
  const auto account = [&] {
    const Clock::time_point now = Clock::now();
    occupied += between(before, now) * (next ? workers.count() : running);
    before = now;
    progress.seconds = between(start, now);
    progress.waiting = std::max(0.0, occupied - progress.working);
    progress.workers = workers.count();
  };
  while (!progress.is_stopped && (next || running > 0)) {
    while (next && workers.free() > 0) {
      workers.start(order(*next));
      account();
      ++running;
      next = handout.next();
    }
    // The workers are busy by now: writing keeps nobody waiting.
    store.add(results);
    results.clear();
    if (next && workers.count() == 0) {
      progress.is_stopped = true;
      break;
    }
    std::vector<CaseEnd> ends = workers.wait(progress.is_stopped);
    account();
    for (CaseEnd& end : ends) {
      --running;
      // Who stops this process may have sent its signal to the case, too.
      if (progress.is_stopped && (!end.result || end.result->failed())) continue;
      if (!end.result && handout.lost(end.index)) continue;
      if (!end.result) {
        end.result.emplace();
        end.result->name = order(end.index).name;
        end.result->problem =
            fmt::format("It was killed from outside, {} times", Handout::kAttempts);
      }
      progress.working += end.result->seconds;
      ++(end.result->failed() ? progress.failed : progress.done);
      results.push_back(std::move(*end.result));
    }
    if (!next) next = handout.next();  // what was lost
    if (between(said, Clock::now()) >= 1) {
      said = Clock::now();
      say(progress);
    }
  }
  workers.stop();
  store.add(results);
  account();
  return progress;
}

}  // namespace prehend::sweep
