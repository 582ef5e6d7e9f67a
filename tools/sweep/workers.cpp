#include "tools/sweep/workers.h"

#include <algorithm>

namespace prehend::tools {
namespace {

class WorkersHere : public Workers {
 public:
  explicit WorkersHere(int count) : slots_(static_cast<std::size_t>(count)) { hold_signals(); }

  int count() const override { return static_cast<int>(slots_.size()); }
  int free() const override {
    return static_cast<int>(std::count(slots_.begin(), slots_.end(), nullptr));
  }

  void start(CaseOrder order) override {
    *std::find(slots_.begin(), slots_.end(), nullptr) =
        std::make_unique<CaseProcess>(std::move(order));
  }

  std::vector<CaseEnd> wait(bool& is_to_end) override {
    double seconds = 1;
    for (const auto& one : slots_) {
      if (one) seconds = std::min(seconds, one->seconds_left());
    }
    is_to_end = wait_for_signal(seconds);
    std::vector<CaseEnd> ends;
    for (auto& one : slots_) {
      if (!one) continue;
      if (std::optional<CaseEnd> end = one->poll()) {
        ends.push_back(std::move(*end));
        one.reset();
      }
    }
    return ends;
  }

  void stop() override {
    for (const auto& one : slots_) {
      if (one) one->ask_to_end();
    }
    for (auto& one : slots_) one.reset();
  }

 private:
  std::vector<std::unique_ptr<CaseProcess>> slots_;
};

}  // namespace

std::unique_ptr<Workers> workers_here(int count) { return std::make_unique<WorkersHere>(count); }

}  // namespace prehend::tools
