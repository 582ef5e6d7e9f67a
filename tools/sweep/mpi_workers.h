#pragma once

#include <functional>
#include <memory>

#include "tools/sweep/workers.h"

namespace prehend::tools {

/// Whether this program was built with Boost.MPI; all below throws InputError where it was not.
bool has_mpi();

/// MPI from its beginning to its end. Rank 0 hands out; the others, each in a process of its own on
/// whatever host, run one case at a time. Each says now and then that it is there; a rank that does
/// not for `lost_after` seconds, or whose death is seen, is lost, and its case is given to another.
/// The others end when the first one does. That a rank may die without the others needs `mpirun
/// --enable-recovery`; else the start after that goes on.
class MpiSession {
 public:
  /// lost_after [s]. @throws InputError when there are less than 2 ranks.
  explicit MpiSession(double lost_after);
  /// Rank 0 tells the others to end.
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;

  bool hands_out() const;
  /// @pre hands_out()
  std::unique_ptr<Workers> workers();
  /// What the other ranks do until rank 0 tells them to end. The exit code. @pre !hands_out()
  int serve();

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::tools
