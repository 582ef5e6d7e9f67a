#include "prehend/sweep/workers/workers.h"

#include <algorithm>
#include <utility>

namespace prehend::sweep {
namespace {

class WorkersHere : public Workers {
 public:
  WorkersHere(int count, CaseBody body)
      : body_(std::move(body)), slots_(static_cast<std::size_t>(count)) {
    hold_signals();
  }

  int count() const override { return static_cast<int>(slots_.size()); }
  int free() const override {
    return static_cast<int>(std::count(slots_.begin(), slots_.end(), nullptr));
  }

  void start(CaseOrder order) override {
    *std::find(slots_.begin(), slots_.end(), nullptr) =
        std::make_unique<CaseProcess>(std::move(order), body_);
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
  CaseBody body_;
  std::vector<std::unique_ptr<CaseProcess>> slots_;
};

}  // namespace

std::unique_ptr<Workers> workers_here(int count, CaseBody body) {
  return std::make_unique<WorkersHere>(count, std::move(body));
}

}  // namespace prehend::sweep
