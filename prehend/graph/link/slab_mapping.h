#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/shared_bytes.h"

namespace prehend::graph {

/// Whether this process can open shared memory of that one: same host, same name space of process
/// numbers, and the right to look into it. `space`: what process_space() says there.
bool can_open_slabs_of(std::int64_t pid, const std::string& space);

/// The slabs of other processes that this node has mapped. In the loop's thread only; what
/// take_lease gave may live on anywhere.
class SlabMappings {
 public:
  struct Lease {
    std::optional<SharedBytes> bytes;  ///< leased until its last copy goes
    bool can_open = true;              ///< false: shared memory of that process is out of reach
    std::string error;                 ///< why there are no bytes
  };
  Lease take_lease(const msgs::graph::SlabContent& content, std::uint32_t reader);
  /// Lets go of slabs that their publishers have retired or whose process has ended.
  void trim();
  std::size_t size() const { return mappings_.size(); }

 private:
  class Mapping;

  std::map<std::pair<std::int64_t, std::uint64_t>, std::shared_ptr<Mapping>> mappings_;
};

}  // namespace prehend::graph
