#include "drivers/camera/driver/depth_device.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "drivers/wire/stream/reopening.h"

namespace prehend::drivers::camera {
namespace {

constexpr Time kPatience = std::chrono::milliseconds(50);

}  // namespace

DepthDevice::DepthDevice(const DepthDeviceOptions& options, Open open, OnView on_view, Note note)
    : options_(options),
      open_(std::move(open)),
      on_view_(std::move(on_view)),
      note_(std::move(note)),
      delivery_(options.most_rate) {
  if (!(options.most_rate >= 0 && std::isfinite(options.most_rate) && options.stale_time > 0 &&
        options.retry > 0 && options.grace >= 0)) {
    throw std::invalid_argument("depth camera: a rate or time is below 0, or not finite");
  }
  thread_ = std::thread([this] { run(); });
}

DepthDevice::~DepthDevice() {
  ends_ = true;
  thread_.join();
}

DepthStatistics DepthDevice::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

std::string DepthDevice::trouble() const {
  const std::lock_guard lock(mutex_);
  if (!trouble_.empty() || !is_open_ || is_at_end_) return trouble_;
  if (steady_now() - last_view_ < to_time(options_.stale_time)) return {};
  return fmt::format("no depth image for {:g} s", options_.stale_time);
}

std::string DepthDevice::remark() const {
  const std::lock_guard lock(mutex_);
  return remark_;
}

void DepthDevice::run() {
  Reopening reopening(
      options_.retry,
      [this](bool is_problem, const std::string& words) {
        note_(is_problem, words);
        const std::lock_guard lock(mutex_);
        trouble_ = is_problem ? words : "";
      },
      options_.grace);
  std::unique_ptr<DepthSource> source;
  while (!ends_) {
    if (!source) {
      source = reopening.attempt(open_, std::chrono::milliseconds(20));
      if (!source) continue;
      if (!source->refused().empty()) note_(true, source->refused());
      const std::lock_guard lock(mutex_);
      remark_ = source->refused();
      is_open_ = true;
      last_view_ = steady_now();
      ++statistics_.connections;
    }
    try {
      std::optional<DepthView> view =
          source->next(kPatience, [this](Time stamp) { return delivery_.lets_through(stamp); });
      {
        const std::lock_guard lock(mutex_);
        statistics_.unpaired = unpaired_before_ + source->unpaired();
      }
      if (view) take(std::move(*view));
      if (source->is_at_end()) {
        if (!is_at_end_) note_(false, source->name() + " is at its end");
        is_at_end_ = true;
        std::this_thread::sleep_for(kPatience);
      }
    } catch (const std::exception& error) {  // SourceLost, and what a library may throw
      {
        const std::lock_guard lock(mutex_);
        unpaired_before_ += source->unpaired();
        ++statistics_.lost;
        is_open_ = false;
        trouble_ = error.what();
      }
      source.reset();
      reopening.tell(error.what());
    }
  }
}

void DepthDevice::take(DepthView view) {
  {
    const std::lock_guard lock(mutex_);
    ++statistics_.views;
    last_view_ = steady_now();
  }
  if (!view.is_empty()) on_view_(std::move(view));
}

}  // namespace prehend::drivers::camera
