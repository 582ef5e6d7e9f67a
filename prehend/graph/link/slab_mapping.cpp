#include "prehend/graph/link/slab_mapping.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "prehend/graph/link/runtime_folder.h"
#include "prehend/graph/link/slab.h"

namespace prehend::graph {

bool can_open_slabs_of(std::int64_t pid, const std::string& space) {
  static const std::string own_space = process_space();
  return pid > 0 && space == own_space &&
         ::access(fmt::format("/proc/{}/fd", pid).c_str(), R_OK | X_OK) == 0;
}

// The header is mapped to be written, for the leases; the content to be read only.
class SlabMappings::Mapping {
 public:
  static std::shared_ptr<Mapping> open(const msgs::graph::SlabContent& content,
                                       std::string& error) {
    const std::string path = fmt::format("/proc/{}/fd/{}", content.pid(), content.file());
    const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
      error = path + ": " + std::strerror(errno);
      return nullptr;
    }
    auto mapping = std::make_shared<Mapping>();
    const bool good = mapping->map(file) && mapping->header().magic == SlabHeader::kMagic &&
                      mapping->header().id == content.id() &&
                      mapping->header().capacity <= mapping->size_;
    ::close(file);
    if (good) return mapping;
    error = path + " is not the slab that was announced";
    return nullptr;
  }

  ~Mapping() {
    if (header_ != MAP_FAILED) ::munmap(header_, kSlabHeaderBytes);
    if (data_ != MAP_FAILED) ::munmap(data_, size_);
  }

  SlabHeader& header() const { return *static_cast<SlabHeader*>(header_); }
  const std::uint8_t* data() const { return static_cast<const std::uint8_t*>(data_); }
  std::size_t size() const { return size_; }

  // Turns a grant into a lease; false when there is none.
  bool take(std::uint32_t reader, std::uint32_t generation) const {
    return change(reader, generation, [](std::uint64_t word) {
      return (word >> 16 & 0xffff) == 0 ? word : word - (1u << 16) + 1;
    });
  }
  void give_back(std::uint32_t reader, std::uint32_t generation) const {
    change(reader, generation,
           [](std::uint64_t word) { return (word & 0xffff) == 0 ? word : word - 1; });
  }

 private:
  bool map(int file) {
    struct stat status = {};
    const int seals = ::fcntl(file, F_GET_SEALS);
    if (::fstat(file, &status) != 0 || seals < 0 || !(seals & F_SEAL_SHRINK) ||
        status.st_size <= static_cast<off_t>(kSlabHeaderBytes)) {
      return false;
    }
    size_ = static_cast<std::size_t>(status.st_size) - kSlabHeaderBytes;
    header_ = ::mmap(nullptr, kSlabHeaderBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    data_ = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, file, kSlabHeaderBytes);
    return header_ != MAP_FAILED && data_ != MAP_FAILED;
  }

  template <class Change>
  bool change(std::uint32_t reader, std::uint32_t generation, Change&& next) const {
    auto& word = header().leases[reader];
    std::uint64_t old = word.load(std::memory_order_acquire);
    while (true) {
      if (old >> 32 != generation) return false;
      const std::uint64_t wanted = next(old);
      if (wanted == old) return false;
      if (word.compare_exchange_weak(old, wanted, std::memory_order_acq_rel)) return true;
    }
  }

  void* header_ = MAP_FAILED;
  void* data_ = MAP_FAILED;
  std::size_t size_ = 0;
};

SlabMappings::Lease SlabMappings::take_lease(const msgs::graph::SlabContent& content,
                                             std::uint32_t reader) {
  Lease result;
  const std::pair key{content.pid(), content.id()};
  auto found = mappings_.find(key);
  if (found == mappings_.end()) {
    auto mapping = Mapping::open(content, result.error);
    result.can_open = mapping != nullptr;
    if (!mapping) return result;
    found = mappings_.emplace(key, std::move(mapping)).first;
  }
  const auto& mapping = found->second;
  if (reader == 0 || reader > kMaxSlabReaders || content.size() > mapping->size() ||
      content.offset() > mapping->size() - content.size() ||
      !mapping->take(reader, content.generation())) {
    result.error = "the publisher has taken it back";
    return result;
  }
  struct Holder {
    std::shared_ptr<const Mapping> mapping;
    std::uint32_t reader, generation;
    ~Holder() { mapping->give_back(reader, generation); }
  };
  std::shared_ptr<Holder> holder(new Holder{mapping, reader, content.generation()});
  result.bytes = SharedBytes(mapping->data() + content.offset(), content.size(), std::move(holder));
  return result;
}

void SlabMappings::trim() {
  std::erase_if(mappings_, [](const auto& item) {
    return item.second->header().retired.load(std::memory_order_acquire) != 0 ||
           !is_process_alive(item.first.first);
  });
}

}  // namespace prehend::graph
