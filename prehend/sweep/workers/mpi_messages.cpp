#include "prehend/sweep/workers/mpi_messages.h"

#include <unistd.h>

#include <chrono>

namespace prehend::sweep {

void MpiPost::clear() {
  std::erase_if(sent_, [](boost::mpi::request& one) {
    try {
      return one.test().has_value();
    } catch (const boost::mpi::exception&) {
      return true;  // who did not get it is lost by its silence
    }
  });
}

void MpiPost::flush(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  for (clear(); !sent_.empty() && Clock::now() < end; clear()) {
    usleep(static_cast<useconds_t>(1e6 * kLook));
  }
}

}  // namespace prehend::sweep
