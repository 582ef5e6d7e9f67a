#pragma once

#include <functional>

#include "prehend/sweep/workers/workers.h"

namespace prehend::sweep {

/// MPI from its beginning to its end. In rank 0 it calls `hand_out` with the other ranks as workers
/// and returns what that returns; the others, on whatever hosts, run cases one at a time, each in a
/// process that does `body`, until rank 0 tells them to end, which it does in any case. A rank that
/// says nothing for `lost_after`
/// [s] is lost; where one still is at the end, the end is MPI_Abort with what would be returned, as
/// MPI_Finalize would wait for it. @throws what `hand_out` does; InputError when there are less
/// than two ranks, no MPI launcher started this program, or it was built without MPI.
int hand_out_to_ranks(double lost_after, const CaseBody& body,
                      const std::function<int(Workers&)>& hand_out);

}  // namespace prehend::sweep
