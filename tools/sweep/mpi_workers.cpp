#include "tools/sweep/mpi_workers.h"

#include "prehend/text/input_error.h"

#ifdef PREHEND_HAS_MPI

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include <boost/mpi.hpp>
#include <boost/serialization/string.hpp>
#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

namespace boost::serialization {

template <class Archive>
void serialize(Archive& archive, prehend::sweep::ResultSource& source, unsigned) {
  archive& source.kind& source.file& source.patterns;
}

template <class Archive>
void serialize(Archive& archive, prehend::tools::CaseOrder& order, unsigned) {
  archive& order.index& order.name& order.words& order.folder& order.results& order.timeout& order
      .keep;
}

template <class Archive>
void serialize(Archive& archive, prehend::sweep::CaseResult& result, unsigned) {
  archive& result.name& result.problem& result.output& result.rows.names& result.rows.rows& result
      .seconds& result.worker;
}

}  // namespace boost::serialization

namespace prehend::tools {
namespace {

namespace mpi = boost::mpi;
using Clock = std::chrono::steady_clock;

enum Tag { kRun, kStop, kAlive, kDone, kKilled, kGone };

constexpr double kSign = 0.5;      // s, between signs of life
constexpr double kLook = 0.001;    // s, between looks for messages: MPI itself would spin
constexpr double kPatience = 600;  // s, of a worker with a silent rank 0, which may be reading
constexpr double kFarewell = 10;   // s, for the others to end what they run

double since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

}  // namespace

struct MpiSession::Implementation {
  struct Rank {
    std::optional<std::int64_t> runs;  // index of its case
    Clock::time_point heard = Clock::now();
    bool is_lost = false, is_gone = false;
    bool is_there() const { return !is_lost && !is_gone; }
  };

  explicit Implementation(double seconds)
      : lost_after(seconds),
        environment(mpi::threading::single, false),
        ranks(static_cast<std::size_t>(world.size())) {
    // A message to a rank that died must not end this one.
    MPI_Comm_set_errhandler(world, MPI_ERRORS_RETURN);
  }

  template <class... Value>
  void tell(int rank, Tag tag, const Value&... value) {
    try {
      // Not waited for: a rank that died takes nothing.
      sent.push_back(world.isend(rank, tag, value...));
    } catch (const mpi::exception&) {
      ranks[static_cast<std::size_t>(rank)].heard = {};  // it is lost
    }
    std::erase_if(sent, [](mpi::request& one) { return one.test().has_value(); });
  }

  // What the others say. Lost ones that come back are told to end: their cases are others' by now.
  void listen(std::vector<CaseEnd>* ends) {
    while (const auto message = world.iprobe(mpi::any_source, mpi::any_tag)) {
      const int number = message->source();
      Rank& rank = ranks[static_cast<std::size_t>(number)];
      rank.heard = Clock::now();
      CaseEnd end;
      if (message->tag() == kDone) {
        world.recv(number, kDone, end.result.emplace());
      } else {
        world.recv(number, message->tag());
      }
      if (rank.is_lost) {
        tell(number, kStop);
      } else if (message->tag() == kDone || message->tag() == kKilled) {
        end.index = rank.runs.value();
        rank.runs.reset();
        ends->push_back(std::move(end));
      } else if (message->tag() == kGone) {
        leave(rank, ends);
        rank.is_gone = true;
      }
    }
  }

  void leave(Rank& rank, std::vector<CaseEnd>* ends) {
    if (rank.runs) ends->push_back({*rank.runs, {}});
    rank.runs.reset();
  }

  void find_lost(std::vector<CaseEnd>* ends) {
    for (std::size_t i = 1; i < ranks.size(); ++i) {
      Rank& rank = ranks[i];
      if (!rank.is_there() || since(rank.heard) < lost_after) continue;
      std::fprintf(stderr, "Rank %d is lost; others get its case\n", static_cast<int>(i));
      rank.is_lost = true;
      leave(rank, ends);
    }
  }

  void say_alive() {
    if (since(said) < kSign) return;
    said = Clock::now();
    for (std::size_t i = 1; i < ranks.size(); ++i) {
      if (ranks[i].is_there()) tell(static_cast<int>(i), kAlive);
    }
  }

  // Others end; true when all did.
  bool dismiss() {
    for (std::size_t i = 1; i < ranks.size(); ++i) {
      if (ranks[i].is_there()) tell(static_cast<int>(i), kStop);
    }
    const auto is_there = [](const Rank& rank) { return rank.is_there(); };
    const Clock::time_point start = Clock::now();
    std::vector<CaseEnd> ignored;
    while (std::any_of(ranks.begin() + 1, ranks.end(), is_there) && since(start) < kFarewell) {
      listen(&ignored);
      usleep(1000);
    }
    return std::all_of(ranks.begin() + 1, ranks.end(),
                       [](const Rank& rank) { return rank.is_gone; });
  }

  double lost_after;
  mpi::environment environment;
  mpi::communicator world;
  std::vector<Rank> ranks;  // of rank 0, about the others; the first one is not used
  std::vector<mpi::request> sent;
  Clock::time_point said{};
};

namespace {

class MpiWorkers : public Workers {
 public:
  explicit MpiWorkers(MpiSession::Implementation& session) : session_(session) {}

  int count() const override {
    return count_of([](const auto& rank) { return rank.is_there(); });
  }
  int free() const override {
    return count_of([](const auto& rank) { return rank.is_there() && !rank.runs; });
  }

  void start(CaseOrder order) override {
    for (std::size_t i = 1; i < session_.ranks.size(); ++i) {
      MpiSession::Implementation::Rank& rank = session_.ranks[i];
      if (!rank.is_there() || rank.runs) continue;
      rank.runs = order.index;
      session_.tell(static_cast<int>(i), kRun, order);
      return;
    }
  }

  std::vector<CaseEnd> wait(bool& is_to_end) override {
    std::vector<CaseEnd> ends;
    const Clock::time_point start = Clock::now();
    while (ends.empty() && since(start) < 1 && !is_to_end) {
      session_.say_alive();
      session_.listen(&ends);
      session_.find_lost(&ends);
      if (ends.empty()) is_to_end = wait_for_signal(kLook);
    }
    return ends;
  }

  // They end what they run when the session ends.
  void stop() override {}

 private:
  template <class Is>
  int count_of(Is is) const {
    return static_cast<int>(std::count_if(session_.ranks.begin() + 1, session_.ranks.end(), is));
  }

  MpiSession::Implementation& session_;
};

}  // namespace

bool has_mpi() { return true; }

MpiSession::MpiSession(double lost_after) {
  hold_signals();  // before MPI starts threads of its own, which take them else
  implementation_ = std::make_unique<Implementation>(lost_after);
  if (implementation_->world.size() < 2) {
    throw text::InputError("--mpi needs at least 2 ranks, one hands out",
                           "Start it by mpirun -n 3 prehend sweep ..., or leave --mpi out");
  }
}

MpiSession::~MpiSession() {
  if (!implementation_ || implementation_->world.size() < 2 || !hands_out()) return;
  if (implementation_->dismiss()) return;
  // MPI's own end would wait for those that are lost.
  std::fflush(nullptr);
  MPI_Abort(implementation_->world, 0);
}

bool MpiSession::hands_out() const { return implementation_->world.rank() == 0; }

std::unique_ptr<Workers> MpiSession::workers() {
  return std::make_unique<MpiWorkers>(*implementation_);
}

int MpiSession::serve() {
  Implementation& session = *implementation_;
  std::unique_ptr<CaseProcess> running;
  Clock::time_point heard = Clock::now();
  bool is_to_end = false;
  while (!is_to_end && since(heard) < kPatience) {
    if (since(session.said) >= kSign) {
      session.said = Clock::now();
      session.tell(0, kAlive);
    }
    while (const auto message = session.world.iprobe(0, mpi::any_tag)) {
      heard = Clock::now();
      CaseOrder order;
      if (message->tag() == kRun) {
        session.world.recv(0, kRun, order);
        running = std::make_unique<CaseProcess>(std::move(order));
      } else {
        session.world.recv(0, message->tag());
        is_to_end = is_to_end || message->tag() == kStop;
      }
    }
    if (const std::optional<CaseEnd> end = running ? running->poll() : std::nullopt) {
      running.reset();
      if (end->result) {
        session.tell(0, kDone, *end->result);
      } else {
        session.tell(0, kKilled);
      }
    }
    is_to_end = wait_for_signal(kLook) || is_to_end;
  }
  running.reset();
  session.world.send(0, kGone);
  return 0;
}

}  // namespace prehend::tools

#else

namespace prehend::tools {
namespace {

[[noreturn]] void refuse() {
  throw text::InputError("This prehend was built without MPI",
                         "Install libboost-mpi-dev and libopenmpi-dev and build it again, or leave "
                         "--mpi out");
}

}  // namespace

struct MpiSession::Implementation {};
bool has_mpi() { return false; }
MpiSession::MpiSession(double) { refuse(); }
MpiSession::~MpiSession() = default;
bool MpiSession::hands_out() const { refuse(); }
std::unique_ptr<Workers> MpiSession::workers() { refuse(); }
int MpiSession::serve() { refuse(); }

}  // namespace prehend::tools

#endif
