#include "prehend/sweep/workers/mpi_workers.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace prehend::sweep {
namespace {

// Longer than a rank takes to end its case.
constexpr double kFarewell = 10;  // s

double passed_since(std::chrono::steady_clock::time_point then) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - then).count();
}

}  // namespace

MpiWorkers::MpiWorkers(MpiPost& post, double lost_after) : post_(post), lost_after_(lost_after) {
  for (int number = 1; number < post.world().size(); ++number) {
    Rank& rank = ranks_.emplace_back();
    rank.number = number;
    rank.heard = listened_;
  }
}

int MpiWorkers::count() const {
  return static_cast<int>(
      std::count_if(ranks_.begin(), ranks_.end(), [](const Rank& rank) { return !rank.is_out; }));
}

int MpiWorkers::free() const {
  return static_cast<int>(std::count_if(ranks_.begin(), ranks_.end(), [](const Rank& rank) {
    return !rank.is_out && !rank.is_told && !rank.runs;
  }));
}

void MpiWorkers::start(CaseOrder order) {
  const auto rank = std::find_if(ranks_.begin(), ranks_.end(), [](const Rank& one) {
    return !one.is_out && !one.is_told && !one.runs;
  });
  rank->runs = order.index;
  try {
    post_.send(rank->number, kRun, order);
  } catch (const boost::mpi::exception&) {
    rank->heard = {};  // it is lost
  }
}

std::vector<CaseEnd> MpiWorkers::wait(bool& is_to_end) {
  std::vector<CaseEnd> ends;
  const Clock::time_point start = Clock::now();
  while (!is_to_end && passed_since(start) < 1) {
    say_alive();
    listen(ends);
    find_lost(ends);
    if (!ends.empty()) break;
    // What ended before it is taken first.
    if (!problem_.empty()) throw std::runtime_error(std::exchange(problem_, {}));
    is_to_end = wait_for_signal(kLook);
  }
  return ends;
}

void MpiWorkers::stop() {
  for (Rank& rank : ranks_) tell_stop(rank);
  const auto is_awaited = [](const Rank& rank) { return !rank.is_out && !rank.is_gone; };
  const Clock::time_point start = Clock::now();
  std::vector<CaseEnd> without_results;
  do {
    listen(without_results);
    wait_for_signal(kLook);
  } while (std::any_of(ranks_.begin(), ranks_.end(), is_awaited) &&
           passed_since(start) < kFarewell);
  if (!problem_.empty()) fmt::print(stderr, "{}\n", std::exchange(problem_, {}));
}

bool MpiWorkers::have_all_ended() const {
  return std::all_of(ranks_.begin(), ranks_.end(), [](const Rank& rank) { return rank.is_gone; });
}

void MpiWorkers::tell_stop(Rank& rank) {
  if (std::exchange(rank.is_told, true)) return;
  try {
    post_.send(rank.number, kStop);
  } catch (const boost::mpi::exception&) {
    rank.heard = {};
  }
}

void MpiWorkers::say_alive() {
  if (passed_since(said_) < kSign) return;
  said_ = Clock::now();
  for (Rank& rank : ranks_) {
    if (rank.is_out || rank.is_told) continue;
    try {
      post_.send(rank.number, kAlive);
    } catch (const boost::mpi::exception&) {
      rank.heard = {};
    }
  }
}

void MpiWorkers::listen(std::vector<CaseEnd>& ends) {
  const double gap = passed_since(listened_);
  listened_ = Clock::now();
  if (gap > kSign) {
    for (Rank& rank : ranks_) {
      rank.heard += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap));
    }
  }
  while (const auto message = post_.world().iprobe(boost::mpi::any_source, boost::mpi::any_tag)) {
    Rank& rank = ranks_[static_cast<std::size_t>(message->source() - 1)];
    rank.heard = Clock::now();
    take(rank, message->tag(), ends);
    // It was lost, and is back.
    if (rank.is_out) tell_stop(rank);
  }
}

void MpiWorkers::take(Rank& rank, int tag, std::vector<CaseEnd>& ends) {
  const boost::mpi::communicator& world = post_.world();
  if (tag == kAlive) {
    world.recv(rank.number, tag, rank.where);
  } else if (tag == kEnd) {
    CaseEnd end;
    world.recv(rank.number, tag, end);
    if (rank.runs != end.index) return;  // others got it when this one was lost
    rank.runs.reset();
    ends.push_back(std::move(end));
  } else if (tag == kFailed) {
    std::string why;
    world.recv(rank.number, tag, why);
    problem_ += fmt::format("{}Rank {} ({}): {}", problem_.empty() ? "" : "\n", rank.number,
                            rank.where, why);
    tell_stop(rank);  // its case stays its own, so that wait() is called again, and throws
  } else {
    world.recv(rank.number, tag);
    rank.is_gone = true;
    if (rank.is_told || rank.is_out) return;
    say_out(rank, "ended before the others");
    leave_out(rank, ends);
  }
}

void MpiWorkers::say_out(const Rank& rank, const std::string& why) const {
  fmt::print(stderr, "Rank {} ({}) {}{}\n", rank.number, rank.where, why,
             rank.runs ? "; another gets its case" : "");
}

void MpiWorkers::leave_out(Rank& rank, std::vector<CaseEnd>& ends) {
  rank.is_out = true;
  if (rank.runs) ends.push_back({*std::exchange(rank.runs, {}), {}});
}

void MpiWorkers::find_lost(std::vector<CaseEnd>& ends) {
  for (Rank& rank : ranks_) {
    if (rank.is_out || rank.is_gone || passed_since(rank.heard) < lost_after_) continue;
    say_out(rank, fmt::format("has said nothing for {:g} s and is lost", lost_after_));
    leave_out(rank, ends);
  }
}

}  // namespace prehend::sweep
