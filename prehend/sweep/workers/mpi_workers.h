#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "prehend/sweep/workers/mpi_messages.h"
#include "prehend/sweep/workers/workers.h"

namespace prehend::sweep {

/// The other ranks, for rank 0. One that says nothing for `lost_after` [s] is lost, and its case
/// ends without a result, as that of one that ends by a signal. The time in which this rank itself
/// does not listen does not count. A lost one that speaks again is told to end: its case may be
/// another's by then.
class MpiWorkers : public Workers {
 public:
  /// `post` lives as long. Signals have to be held, hold_signals().
  MpiWorkers(MpiPost& post, double lost_after);

  int count() const override;
  int free() const override;
  void start(CaseOrder order) override;
  /// @throws std::runtime_error with the words of a rank that failed: where, and why.
  std::vector<CaseEnd> wait(bool& is_to_end) override;
  /// Tells the ranks to end, and waits until they did, 10 s at most.
  void stop() override;

  /// All ended by what stop() told them: MPI_Finalize, which waits for each, comes to an end.
  bool have_all_ended() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Rank {
    int number = 0;
    std::string where;                 // host and process, once it said so
    std::optional<std::int64_t> runs;  // its case's index
    Clock::time_point heard;
    bool is_out = false;   // lost, or ended by itself
    bool is_told = false;  // to end
    bool is_gone = false;  // it said that it ends
  };

  void tell_stop(Rank& rank);
  void say_alive();
  void listen(std::vector<CaseEnd>& ends);
  void take(Rank& rank, int tag, std::vector<CaseEnd>& ends);
  void say_out(const Rank& rank, const std::string& why) const;
  void leave_out(Rank& rank, std::vector<CaseEnd>& ends);
  void find_lost(std::vector<CaseEnd>& ends);

  MpiPost& post_;
  const double lost_after_;
  std::vector<Rank> ranks_;  // but rank 0
  Clock::time_point listened_ = Clock::now(), said_{};
  std::string problem_;  // of a rank that failed; not yet thrown
};

}  // namespace prehend::sweep
