#include "prehend/graph/link/io_loop.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace prehend::graph {

IoLoop::IoLoop() : context_(1), wake_fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

IoLoop::~IoLoop() { ::close(wake_fd_); }

bool IoLoop::post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    posted_.push_back(std::move(work));
    if (posted_.size() > 1) return true;  // woken already
  }
  wake();
  return true;
}

void IoLoop::wake() const {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and then the loop is woken anyway.
  [[maybe_unused]] const auto written = ::write(wake_fd_, &one, sizeof one);
}

void IoLoop::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  wake();
}

void IoLoop::watch(zmq::socket_ref socket, std::function<void()> readable) {
  watches_[socket.handle()] = std::move(readable);
}

void IoLoop::unwatch(zmq::socket_ref socket) { watches_.erase(socket.handle()); }

void IoLoop::every(std::chrono::milliseconds period, std::function<void()> tick) {
  ticks_.push_back({period, std::chrono::steady_clock::now() + period, std::move(tick)});
}

void IoLoop::soon(std::function<void()> work) { soon_.push_back(std::move(work)); }

void IoLoop::run_posted() {
  std::vector<std::function<void()>> work;
  {
    const std::lock_guard lock(mutex_);
    work.swap(posted_);
  }
  for (auto& item : work) item();
}

void IoLoop::run_ticks() {
  const Time now = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < ticks_.size(); ++i) {
    if (ticks_[i].next > now) continue;
    ticks_[i].next = now + ticks_[i].period;
    const auto work = ticks_[i].work;
    work();
  }
}

void IoLoop::run_soon() {
  std::vector<std::function<void()>> work;
  work.swap(soon_);
  for (auto& item : work) item();
}

std::chrono::milliseconds IoLoop::time_to_next_tick() const {
  if (!soon_.empty()) return std::chrono::milliseconds(1);
  Time next = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  for (const Tick& tick : ticks_) next = std::min(next, tick.next);
  const auto left = next - std::chrono::steady_clock::now();
  return std::max(std::chrono::milliseconds(0), std::chrono::ceil<std::chrono::milliseconds>(left));
}

void IoLoop::run() {
  while (true) {
    std::vector<zmq::pollitem_t> items;
    items.push_back({nullptr, wake_fd_, ZMQ_POLLIN, 0});
    for (const auto& [socket, readable] : watches_) items.push_back({socket, 0, ZMQ_POLLIN, 0});
    try {
      zmq::poll(items, time_to_next_tick());
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
      continue;
    }
    if (items[0].revents) {
      std::uint64_t count = 0;
      [[maybe_unused]] const auto got = ::read(wake_fd_, &count, sizeof count);
    }
    run_posted();
    for (std::size_t i = 1; i < items.size(); ++i) {
      if (!items[i].revents) continue;
      const auto watch = watches_.find(items[i].socket);
      if (watch == watches_.end()) continue;  // closed by one before it
      const auto readable = watch->second;
      readable();
    }
    run_soon();
    run_ticks();
    const std::lock_guard lock(mutex_);
    if (closed_ && posted_.empty()) return;
  }
}

}  // namespace prehend::graph
