#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace prehend::bench {

/// A transport that is measured.
struct PeerKind {
  std::string name;
  std::string description;  ///< what is measured, one line
  std::vector<std::size_t> sizes;
  bool same_process = false;
  bool throughput = false;  ///< messages/s instead of latency
  bool service = false;     ///< a round trip, not one way
  bool ros1 = false;        ///< another program
};

const std::vector<PeerKind>& peer_kinds();

/// One line of the table.
struct Row {
  const PeerKind* kind = nullptr;
  std::size_t bytes = 0;
  std::string name() const;  ///< "slab_copy/4MB"
};

/// All rows whose name the regular expression `filter` finds (empty: all). Throws BenchError when
/// it is malformed or finds none, naming the nearest.
std::vector<Row> rows(const std::string& filter, bool with_ros1);

/// "100B", "640KB", "4MB".
std::string size_name(std::size_t bytes);

}  // namespace prehend::bench
