#include "prehend/sweep/workers/mpi_ranks.h"

#include "prehend/text/input_error.h"

#ifdef PREHEND_HAS_MPI

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <fmt/format.h>
#include <boost/mpi/environment.hpp>

#include "prehend/sweep/workers/mpi_messages.h"
#include "prehend/sweep/workers/mpi_servant.h"
#include "prehend/sweep/workers/mpi_workers.h"

namespace prehend::sweep {
namespace {

namespace mpi = boost::mpi;

// Open MPI's mpirun; srun --mpi=pmix and others with PMIx; MPICH's mpirun and srun --mpi=pmi2.
bool has_launcher() {
  const std::array<const char*, 3> of_launchers{"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"};
  return std::any_of(of_launchers.begin(), of_launchers.end(),
                     [](const char* name) { return std::getenv(name) != nullptr; });
}

text::InputError too_few(const std::string& found) {
  return {"--mpi needs two ranks or more, of which the first hands out, and " + found,
          "Start it by `mpirun -n 5 PROGRAM ... --mpi` or `srun --mpi=pmix -n 5 ...`, or "
          "leave --mpi out"};
}

void say_problem(const std::exception& error) {
  fmt::print(stderr, "{}: {}\n", program_invocation_short_name, error.what());
}

[[noreturn]] void end_all(int code) {
  std::fflush(nullptr);
  mpi::environment::abort(code);
  std::_Exit(code);
}

bool have_all_ended(MpiWorkers& workers) {
  try {
    workers.stop();
    return workers.have_all_ended();
  } catch (const mpi::exception& error) {
    say_problem(error);
    return false;
  }
}

int lead(MpiPost& post, double lost_after, const std::function<int(Workers&)>& hand_out) {
  MpiWorkers workers(post, lost_after);
  int code = 1;
  std::exception_ptr problem;
  try {
    code = hand_out(workers);
  } catch (...) {
    problem = std::current_exception();
  }
  if (!have_all_ended(workers)) {
    try {
      if (problem) std::rethrow_exception(problem);
    } catch (const std::exception& error) {
      say_problem(error);
    }
    fmt::print(stderr, "Ranks that are lost are ended by MPI_Abort\n");
    end_all(code);
  }
  if (problem) std::rethrow_exception(problem);
  return code;
}

}  // namespace

int hand_out_to_ranks(double lost_after, const CaseBody& body,
                      const std::function<int(Workers&)>& hand_out) {
  if (!has_launcher()) throw too_few("no mpirun or srun started this one");
  hold_signals();  // before MPI starts threads of its own, which would get them
  const mpi::environment environment(mpi::threading::single, false);
  MpiPost post;
  if (post.world().size() < 2) throw too_few("there is one");
  try {
    return post.world().rank() == 0 ? lead(post, lost_after, hand_out)
                                    : MpiServant(post, body).serve();
  } catch (const mpi::exception& error) {
    say_problem(error);
  } catch (const std::exception& error) {
    if (post.world().rank() == 0) throw;
    say_problem(error);
  }
  // MPI_Finalize might wait for who cannot be reached.
  end_all(1);
}

}  // namespace prehend::sweep

#else

namespace prehend::sweep {

int hand_out_to_ranks(double, const CaseBody&, const std::function<int(Workers&)>&) {
  throw text::InputError("This prehend was built without MPI",
                         "Install libboost-mpi-dev, openmpi-bin and libopenmpi-dev and build it "
                         "again, or leave --mpi out");
}

}  // namespace prehend::sweep

#endif
