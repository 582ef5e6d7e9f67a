// The limit for one copy: a ring of slots in memory that both processes map. The writer copies the
// payload in, the reader looks at it in place and spins for the next one, so that no wake-up by the
// kernel is measured.

#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <thread>

#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>

#include "bench/graph/peers.h"

namespace prehend::bench {
namespace {

namespace ipc = boost::interprocess;

constexpr std::uint64_t kSlots = 4;
constexpr std::size_t kSlotHeader = 64;  // a cache line: the stamp

struct RingHeader {
  alignas(64) std::atomic<std::uint64_t> written;
  alignas(64) std::atomic<std::uint64_t> read;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

std::size_t slot_bytes(std::size_t payload) { return kSlotHeader + (payload + 63) / 64 * 64; }

std::uint8_t* slot(const ipc::mapped_region& region, std::uint64_t index, std::size_t payload) {
  return static_cast<std::uint8_t*>(region.get_address()) + sizeof(RingHeader) +
         (index % kSlots) * slot_bytes(payload);
}

RingHeader& header(const ipc::mapped_region& region) {
  return *static_cast<RingHeader*>(region.get_address());
}

/// Memory without a name in /dev/shm: nothing is left behind however the processes end.
class MemoryFile {
 public:
  explicit MemoryFile(std::size_t bytes) : descriptor_(memfd_create("bench-ring", MFD_CLOEXEC)) {
    if (descriptor_ < 0 || ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) {
      throw BenchError("no shared memory for the ring");
    }
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const {
    return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(descriptor_);
  }

 private:
  int descriptor_;
};

class RingSender : public Sender {
 public:
  explicit RingSender(const Job& job)
      : payload_(job.bytes, kPayloadMark),
        file_(sizeof(RingHeader) + kSlots * slot_bytes(job.bytes)),
        region_(ipc::file_mapping(file_.path().c_str(), ipc::read_write), ipc::read_write) {}
  std::string address() const override { return file_.path(); }
  void wait_until_connected() override {}
  void send() override {
    const std::int64_t stamp = monotonic_now();
    const std::uint64_t index = header(region_).written.load(std::memory_order_relaxed);
    while (index - header(region_).read.load(std::memory_order_acquire) >= kSlots) sched_yield();
    std::uint8_t* target = slot(region_, index, payload_.size());
    std::memcpy(target, &stamp, sizeof(stamp));
    std::memcpy(target + kSlotHeader, payload_.data(), payload_.size());
    header(region_).written.store(index + 1, std::memory_order_release);
  }

 private:
  std::vector<std::uint8_t> payload_;
  MemoryFile file_;
  ipc::mapped_region region_;
};

class RingReceiver : public Receiver {
 public:
  RingReceiver(const Job& job, const std::string& path, OnMessage on_message)
      : region_(ipc::file_mapping(path.c_str(), ipc::read_write), ipc::read_write),
        thread_([this, bytes = job.bytes, on_message = std::move(on_message)] {
          receive(bytes, on_message);
        }) {}
  ~RingReceiver() override {
    stop_ = true;
    thread_.join();
  }

 private:
  void receive(std::size_t bytes, const OnMessage& on_message) {
    for (std::uint64_t index = 0; !stop_;) {
      if (header(region_).written.load(std::memory_order_acquire) == index) {
        sched_yield();
        continue;
      }
      const std::uint8_t* source = slot(region_, index, bytes);
      std::int64_t stamp = 0;
      std::memcpy(&stamp, source, sizeof(stamp));
      if (const char* problem = check_payload(source + kSlotHeader, bytes, bytes)) {
        end_worker(problem);
      }
      on_message(stamp);
      header(region_).read.store(++index, std::memory_order_release);
    }
  }

  ipc::mapped_region region_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Sender> make_ring_sender(const Job& job) {
  return std::make_unique<RingSender>(job);
}
std::unique_ptr<Receiver> make_ring_receiver(const Job& job, const std::string& address,
                                             OnMessage on_message) {
  return std::make_unique<RingReceiver>(job, address, std::move(on_message));
}

}  // namespace prehend::bench
