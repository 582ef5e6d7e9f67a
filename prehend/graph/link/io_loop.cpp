#include "prehend/graph/link/io_loop.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace prehend::graph {
namespace {

bool is_readable(void* socket) {
  return (zmq::socket_ref(zmq::from_handle, socket).get(zmq::sockopt::events) & ZMQ_POLLIN) != 0;
}

}  // namespace

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
  watches_[socket.handle()] = {socket.get(zmq::sockopt::fd), std::move(readable), true};
}

void IoLoop::unwatch(zmq::socket_ref socket) { watches_.erase(socket.handle()); }

void IoLoop::touch(zmq::socket_ref socket) {
  const auto watch = watches_.find(socket.handle());
  if (watch != watches_.end()) watch->second.look = true;
}

// At whole multiples of the period since this loop began, so that ticks of several periods share
// wake-ups, but processes do not all wake at once.
IoLoop::Time IoLoop::next_multiple(std::chrono::milliseconds period) const {
  return begun_ + ((std::chrono::steady_clock::now() - begun_) / period + 1) * period;
}

void IoLoop::every(std::chrono::milliseconds period, std::function<void()> tick) {
  ticks_.push_back({period, next_multiple(period), std::move(tick)});
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
    ticks_[i].next = next_multiple(ticks_[i].period);
    const auto work = ticks_[i].work;
    work();
  }
}

void IoLoop::run_soon() {
  std::vector<std::function<void()>> work;
  work.swap(soon_);
  for (auto& item : work) item();
}

IoLoop::Alarm IoLoop::at(Time when, std::function<void()> work) {
  const Alarm alarm(when, ++alarm_count_);
  alarms_.emplace(alarm, std::move(work));
  return alarm;
}

void IoLoop::run_alarms() {
  const Time now = std::chrono::steady_clock::now();
  while (!alarms_.empty() && alarms_.begin()->first.first <= now) {
    const auto work = std::move(alarms_.begin()->second);
    alarms_.erase(alarms_.begin());
    work();
  }
}

std::chrono::milliseconds IoLoop::time_to_next_tick() const {
  if (!soon_.empty()) return std::chrono::milliseconds(1);
  Time next = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  for (const Tick& tick : ticks_) next = std::min(next, tick.next);
  if (!alarms_.empty()) next = std::min(next, alarms_.begin()->first.first);
  const auto left = next - std::chrono::steady_clock::now();
  return std::max(std::chrono::milliseconds(0), std::chrono::ceil<std::chrono::milliseconds>(left));
}

bool IoLoop::begin_turn() {
  const auto self = std::this_thread::get_id();
  if (turn_taker_ == self || !turn_.try_lock()) return false;
  {
    const std::lock_guard lock(mutex_);
    if (posted_.empty() && !closed_) {
      turn_taker_ = self;
      return true;
    }
  }
  turn_.unlock();
  return false;
}

void IoLoop::end_turn() {
  const bool must_look = look_again() || !soon_.empty();
  turn_taker_ = std::thread::id();
  turn_.unlock();
  if (must_look) wake();
}

// True when a socket that was used has something to receive.
bool IoLoop::look_again() {
  bool any = false;
  for (auto& [socket, watch] : watches_) {
    watch.look = watch.look && is_readable(socket);
    any = any || watch.look;
  }
  return any;
}

// `readable`: sockets whose files tell that. True when there is more to do at once.
bool IoLoop::take_turn(const std::vector<void*>& readable) {
  const std::lock_guard turn(turn_);
  turn_taker_ = std::this_thread::get_id();
  run_posted();
  for (void* socket : readable) touch(zmq::socket_ref(zmq::from_handle, socket));
  std::vector<void*> to_look_at;
  for (const auto& [socket, watch] : watches_) {
    if (watch.look) to_look_at.push_back(socket);
  }
  for (void* socket : to_look_at) {
    const auto watch = watches_.find(socket);
    if (watch == watches_.end() || !is_readable(socket)) continue;  // closed by one before it
    const auto work = watch->second.readable;
    work();
  }
  run_soon();
  run_ticks();
  run_alarms();
  const bool more = look_again();
  turn_taker_ = std::thread::id();
  return more;
}

void IoLoop::wait(std::vector<pollfd>& files, std::chrono::milliseconds timeout,
                  std::chrono::nanoseconds busy_wait) {
  if (busy_wait.count() > 0 && timeout.count() > 0) {
    const Time end = std::chrono::steady_clock::now() + busy_wait;
    do {
      if (::poll(files.data(), files.size(), 0) != 0) return;
      std::this_thread::yield();
    } while (std::chrono::steady_clock::now() < end);
  }
  ::poll(files.data(), files.size(), static_cast<int>(timeout.count()));
}

void IoLoop::run(std::chrono::nanoseconds busy_wait) {
  std::vector<pollfd> files;
  std::vector<void*> sockets;  // of the files behind the first
  bool more = false;
  while (true) {
    files.assign(1, {wake_fd_, POLLIN, 0});
    sockets.clear();
    std::chrono::milliseconds timeout{0};
    {
      const std::lock_guard turn(turn_);
      for (const auto& [socket, watch] : watches_) {
        files.push_back({watch.file, POLLIN, 0});
        sockets.push_back(socket);
      }
      if (!more) timeout = time_to_next_tick();
    }
    wait(files, timeout, busy_wait);
    if (files[0].revents) {
      std::uint64_t count = 0;
      [[maybe_unused]] const auto got = ::read(wake_fd_, &count, sizeof count);
    }
    std::vector<void*> readable;
    for (std::size_t i = 0; i < sockets.size(); ++i) {
      if (files[i + 1].revents) readable.push_back(sockets[i]);
    }
    more = take_turn(readable);
    const std::lock_guard lock(mutex_);
    if (closed_ && posted_.empty()) return;
  }
}

}  // namespace prehend::graph
