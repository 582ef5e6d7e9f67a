#pragma once

#include <string>
#include <vector>

#include <boost/mpi/communicator.hpp>
#include <boost/mpi/exception.hpp>
#include <boost/mpi/request.hpp>
#include <boost/serialization/string.hpp>
#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include "prehend/sweep/workers/case_process.h"

namespace prehend::sweep {

/// Writes the fields to an archive of Boost.Serialization, or reads them, in this order.
template <class Archive, class... Field>
void archive_fields(Archive& archive, Field&... field) {
  ((archive & field), ...);
}

}  // namespace prehend::sweep

namespace boost::serialization {

template <class Archive>
void serialize(Archive& archive, prehend::sweep::ResultSource& source, unsigned) {
  prehend::sweep::archive_fields(archive, source.kind, source.file, source.patterns);
}

template <class Archive>
void serialize(Archive& archive, prehend::sweep::CaseOrder& order, unsigned) {
  prehend::sweep::archive_fields(archive, order.index, order.name, order.words, order.folder,
                                 order.results, order.timeout, order.keep);
}

template <class Archive>
void serialize(Archive& archive, prehend::sweep::CaseResult& result, unsigned) {
  prehend::sweep::archive_fields(archive, result.name, result.problem, result.output,
                                 result.rows.names, result.rows.rows, result.seconds,
                                 result.worker);
}

template <class Archive>
void serialize(Archive& archive, prehend::sweep::CaseEnd& end, unsigned) {
  bool has_result = end.result.has_value();
  prehend::sweep::archive_fields(archive, end.index, has_result);
  if (!has_result) return;
  if (!end.result) end.result.emplace();
  prehend::sweep::archive_fields(archive, *end.result);
}

}  // namespace boost::serialization

namespace prehend::sweep {

/// What a message is about, and what comes with it. Rank 0 hands out; kStop is the last that it
/// tells a rank, and kGone the last that a rank tells it: so no message is left when MPI ends.
enum MpiTag {
  kRun,     // from 0: CaseOrder
  kStop,    // from 0
  kAlive,   // both ways; to 0: where, as this_worker() has it
  kEnd,     // to 0: CaseEnd
  kFailed,  // to 0: what went wrong with the rank itself, as words; kGone follows
  kGone     // to 0
};

constexpr double kSign = 0.5;    // s, between signs of life
constexpr double kLook = 0.001;  // s, between looks for messages: MPI's own waiting spins

/// All ranks of this program, and what this one tells others.
class MpiPost {
 public:
  const boost::mpi::communicator& world() const { return world_; }

  /// Does not wait until it is taken: a rank that died takes nothing.
  /// @throws boost::mpi::exception where MPI knows already that it cannot arrive.
  template <class... Value>
  void send(int rank, MpiTag tag, const Value&... value) {
    clear();
    sent_.push_back(world_.isend(rank, tag, value...));
  }
  /// Waits until all that was sent is taken, `seconds` at most.
  void flush(double seconds);

 private:
  void clear();

  boost::mpi::communicator world_;
  std::vector<boost::mpi::request> sent_;  // they have the messages' memory
};

}  // namespace prehend::sweep
