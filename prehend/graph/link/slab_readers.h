#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "prehend/graph/link/slab.h"

namespace prehend::graph {

/// Which clients read a node's slabs, and their places among the leases. In the loop's thread only.
class SlabReaders {
 public:
  explicit SlabReaders(std::shared_ptr<SlabPool> pool) : pool_(std::move(pool)) {}

  /// The client's place, from 1; 0 when there is none left. A client that comes back keeps its own.
  std::uint32_t join(const std::string& client, std::int64_t pid);
  /// 0: it reads no slabs.
  std::uint32_t place_of(const std::string& client) const;
  /// The connection to the client broke. What a process that lives on holds stays its own until it
  /// gives it back or ends.
  void lose(const std::string& client);
  /// Looks which of the lost have ended.
  void look_after_lost();

 private:
  struct Reader {
    std::uint32_t place = 0;
    std::int64_t pid = 0;
    bool is_lost = false;
  };

  const std::shared_ptr<SlabPool> pool_;
  std::map<std::string, Reader> readers_;
};

}  // namespace prehend::graph
