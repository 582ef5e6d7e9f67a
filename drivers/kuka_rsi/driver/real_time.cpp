#include "drivers/kuka_rsi/driver/real_time.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace prehend::drivers::kuka_rsi {
namespace {

// With a limit of locked memory, what is allocated beyond it later would fail: worse than a page
// that has to be fetched.
bool may_lock_memory() {
  rlimit limit{};
  return ::geteuid() == 0 ||
         (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
}

}  // namespace

std::string ask_for_real_time(int priority) {
  std::string missing;
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters)) {
    missing = std::string("real-time scheduling is not granted (") + std::strerror(error) +
              "): allow rtprio in /etc/security/limits.d";
  }
  const bool locked = may_lock_memory() && ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!locked) {
    missing += std::string(missing.empty() ? "" : "; ") +
               "memory is not locked: allow memlock unlimited there";
  }
  return missing;
}

}  // namespace prehend::drivers::kuka_rsi
