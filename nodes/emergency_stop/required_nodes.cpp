#include "nodes/emergency_stop/required_nodes.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "prehend/graph/link/runtime_folder.h"

namespace prehend::nodes {
namespace {

using namespace std::chrono_literals;
using msgs::graph::NodeRecord;
using std::chrono::steady_clock;

constexpr auto kAsk = 250ms;
constexpr auto kAnswer = 500ms;

// -1 for a process that is not of this host, or is gone.
int open_process(const NodeRecord& record) {
  if (record.process_space() != graph::process_space()) return -1;
  // glibc 2.36 declares pidfd_open without the linkage of C.
  return static_cast<int>(::syscall(SYS_pidfd_open, static_cast<pid_t>(record.pid()), 0));
}

bool has_ended(int process) {
  pollfd item{process, POLLIN, 0};
  return ::poll(&item, 1, 0) > 0;
}

}  // namespace

RequiredNodes::RequiredNodes(std::vector<std::string> names, std::string prefix,
                             const std::string& registry)
    : prefix_(std::move(prefix)), introspection_(registry, kAnswer) {
  for (std::string& name : names) {
    if (name.empty()) throw std::invalid_argument("parameter 'required' has an empty name");
    const bool is_twice = std::ranges::any_of(
        required_, [&](const Required& required) { return required.name == name; });
    if (is_twice) throw std::invalid_argument("parameter 'required' names '" + name + "' twice");
    required_.push_back({.name = std::move(name), .instance = {}});
  }
  awake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (awake_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  if (!required_.empty()) thread_ = std::thread([this] { ask_registry(); });
}

RequiredNodes::~RequiredNodes() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  end_.notify_all();
  if (thread_.joinable()) thread_.join();
  for (const Required& required : required_) {
    if (required.process >= 0) ::close(required.process);
  }
  ::close(awake_);
}

void RequiredNodes::ask_registry() {
  std::unique_lock lock(mutex_);
  do {
    lock.unlock();
    try {
      take(introspection_.nodes(), steady_clock::now());
    } catch (const std::runtime_error&) {
      // No registry: nodes live on without one, and so does what is known of them.
      const std::lock_guard known(mutex_);
      for (Required& required : required_) required.seen = steady_clock::now();
    }
    lock.lock();
  } while (!end_.wait_for(lock, kAsk, [this] { return ends_; }));
}

const NodeRecord* RequiredNodes::record_of(const Required& required,
                                           const std::vector<NodeRecord>& records) const {
  for (const std::string& name : {required.name, prefix_ + required.name}) {
    const auto found =
        std::ranges::find_if(records, [&](const NodeRecord& node) { return node.name() == name; });
    if (found != records.end()) return &*found;
  }
  return nullptr;
}

void RequiredNodes::take(const std::vector<NodeRecord>& records, steady_clock::time_point now) {
  using State = Required::State;
  const std::lock_guard lock(mutex_);
  for (Required& required : required_) {
    const NodeRecord* record = record_of(required, records);
    if (!record) {
      // A new registry is told of everybody within this time.
      if (required.state == State::kThere && now - required.seen > kSilence) {
        lose(required, "it left the graph");
      }
      continue;
    }
    if (std::chrono::nanoseconds(record->silence()) > kSilence) {
      if (required.state == State::kThere) {
        lose(required, fmt::format("it was not heard for {} s",
                                   static_cast<double>(kSilence.count()) * 1e-3));
      }
      continue;
    }
    required.seen = now;
    if (required.state == State::kThere && required.instance == record->instance()) continue;
    if (required.state == State::kThere) lose(required, "it ended and was started again");
    // The one whose process has ended, which the registry has not seen yet.
    if (required.state == State::kLost && required.instance == record->instance() &&
        required.process < 0 && record->process_space() == graph::process_space()) {
      continue;
    }
    const int process = open_process(*record);
    if (process < 0 && record->process_space() == graph::process_space()) continue;  // dead already
    if (required.process >= 0) ::close(required.process);
    required.process = process;
    required.instance = record->instance();
    required.state = State::kThere;
    ::eventfd_write(awake_, 1);
  }
}

// Under the lock.
void RequiredNodes::lose(Required& required, const std::string& reason) {
  required.state = Required::State::kLost;
  losses_.push_back({required.name, reason});
  ::eventfd_write(awake_, 1);
}

std::vector<RequiredNodes::Loss> RequiredNodes::wait_for_losses(
    std::chrono::milliseconds patience) {
  std::vector<pollfd> items{{awake_, POLLIN, 0}};
  {
    const std::lock_guard lock(mutex_);
    for (const Required& required : required_) {
      if (required.process >= 0) items.push_back({required.process, POLLIN, 0});
    }
  }
  ::poll(items.data(), items.size(), static_cast<int>(patience.count()));
  eventfd_t ignored = 0;
  ::eventfd_read(awake_, &ignored);
  const std::lock_guard lock(mutex_);
  for (Required& required : required_) {
    if (required.process < 0 || !has_ended(required.process)) continue;
    ::close(std::exchange(required.process, -1));
    if (required.state == Required::State::kThere) lose(required, "its process ended");
  }
  return std::exchange(losses_, {});
}

std::string RequiredNodes::named(Required::State state) const {
  const std::lock_guard lock(mutex_);
  std::string names;
  for (const Required& required : required_) {
    if (required.state == state) names += (names.empty() ? "" : ", ") + required.name;
  }
  return names;
}

std::string RequiredNodes::away() const { return named(Required::State::kLost); }
std::string RequiredNodes::missing() const { return named(Required::State::kNeverCame); }

}  // namespace prehend::nodes
