#include "prehend/graph/link/slab_readers.h"

#include <bitset>

#include "prehend/graph/link/runtime_folder.h"

namespace prehend::graph {

std::uint32_t SlabReaders::join(const std::string& client, std::int64_t pid) {
  if (!pool_) return 0;
  if (const auto known = readers_.find(client); known != readers_.end()) {
    known->second.is_lost = false;
    return known->second.place;
  }
  std::bitset<kMaxSlabReaders + 1> taken;
  for (const auto& [name, reader] : readers_) taken.set(reader.place);
  for (std::uint32_t place = 1; place <= kMaxSlabReaders; ++place) {
    if (taken.test(place)) continue;
    readers_[client] = {place, pid, false};
    return place;
  }
  return 0;
}

std::uint32_t SlabReaders::place_of(const std::string& client) const {
  const auto found = readers_.find(client);
  return found == readers_.end() || found->second.is_lost ? 0 : found->second.place;
}

void SlabReaders::lose(const std::string& client) {
  const auto found = readers_.find(client);
  if (found == readers_.end()) return;
  pool_->lose_reader(found->second.place, false);
  found->second.is_lost = true;
  look_after_lost();
}

void SlabReaders::look_after_lost() {
  std::erase_if(readers_, [this](const auto& item) {
    const Reader& reader = item.second;
    if (!reader.is_lost || is_process_alive(reader.pid)) return false;
    pool_->lose_reader(reader.place, true);
    return true;
  });
}

}  // namespace prehend::graph
