#include "drivers/camera/driver/camera_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "drivers/wire/stream/reopening.h"

namespace prehend::drivers::camera {
namespace {

constexpr Time kTick = std::chrono::milliseconds(20);
constexpr double kAssumedRate = 30;  // 1/s, of a pair whose sources do not say it

void check_option(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("camera: ") + what);
}

}  // namespace

CameraView split_side_by_side(const Frame& frame) {
  const geometry::ColorImage& both = frame.image;
  if (both.width < 2 || both.width % 2 != 0) {
    throw std::invalid_argument(
        fmt::format("an image of {} pixels' width is not two side by side", both.width));
  }
  CameraView view;
  const int width = both.width / 2;
  view.left = geometry::ColorImage(width, both.height);
  view.right = geometry::ColorImage(width, both.height);
  for (int row = 0; row < both.height; ++row) {
    const auto from = both.data.begin() + std::ptrdiff_t{row} * both.width;
    std::copy_n(from, width, view.left.data.begin() + std::ptrdiff_t{row} * width);
    std::copy_n(from + width, width, view.right->data.begin() + std::ptrdiff_t{row} * width);
  }
  view.stamp = frame.stamp;
  view.is_stamped_by_device = frame.is_stamped_by_device;
  return view;
}

CameraDevice::CameraDevice(const CameraOptions& options, Open open, OnView on_view, Note note)
    : options_(options),
      open_(std::move(open)),
      on_view_(std::move(on_view)),
      note_(std::move(note)),
      begun_(steady_now()),
      sides_(options.kind == CameraKind::kTwo ? 2 : 1),
      start_(begun_),
      exposure_(options.exposure),
      gain_(options.gain),
      delivery_(options.most_rate) {
  check_option(options.most_rate >= 0 && std::isfinite(options.most_rate), "most_rate is below 0");
  check_option(options.pair_tolerance >= 0 && options.pair_tolerance < 1,
               "pair_tolerance is not 0 to 1 s");
  check_option(options.stale_time > 0 && options.retry > 0 && options.grace >= 0,
               "a time is not positive");
  for (std::size_t i = 0; i < sides_.size(); ++i) threads_.emplace_back([this, i] { run(i); });
}

CameraDevice::~CameraDevice() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void CameraDevice::set_exposure(double seconds) {
  const std::lock_guard lock(mutex_);
  exposure_ = seconds;
  ++controls_;
}

void CameraDevice::set_gain(double gain) {
  const std::lock_guard lock(mutex_);
  gain_ = gain;
  ++controls_;
}

CameraStatistics CameraDevice::statistics() const {
  const std::lock_guard lock(mutex_);
  CameraStatistics statistics = statistics_;
  if (pairing_) statistics.unpaired = {pairing_->dropped(0), pairing_->dropped(1)};
  return statistics;
}

std::string CameraDevice::trouble() const {
  const std::lock_guard lock(mutex_);
  for (const Side& side : sides_) {
    if (!side.trouble.empty()) return side.trouble;
  }
  const bool all_open =
      std::all_of(sides_.begin(), sides_.end(), [](const Side& side) { return side.is_open; });
  const bool ended =
      std::any_of(sides_.begin(), sides_.end(), [](const Side& side) { return side.is_at_end; });
  if (!all_open || ended) return {};
  const Time now = steady_now();
  if (now - last_view_.value_or(begun_) < to_time(options_.stale_time)) return {};
  if (pairing_ && statistics_.frames[0] > 0 && statistics_.frames[1] > 0) {
    const double apart = std::abs(to_seconds(pairing_->last_difference().value_or(Time::zero())));
    return fmt::format(
        "no pair for {:g} s: the two cameras' frames are {:.0f} ms apart. Give both one rate, or a "
        "larger pair_tolerance for things at rest",
        options_.stale_time, apart * 1e3);
  }
  return fmt::format("no image for {:g} s", options_.stale_time);
}

std::string CameraDevice::remark() const {
  const std::lock_guard lock(mutex_);
  std::string all;
  for (const Side& side : sides_) {
    if (!side.remark.empty()) all += (all.empty() ? "" : "; ") + side.remark;
  }
  return all;
}

bool CameraDevice::is_at_end() const {
  const std::lock_guard lock(mutex_);
  return std::all_of(sides_.begin(), sides_.end(), [](const Side& side) { return side.is_at_end; });
}

void CameraDevice::say(bool is_problem, const std::string& words) {
  const std::lock_guard lock(note_mutex_);
  note_(is_problem, words);
}

void CameraDevice::lose(std::size_t index, const std::string& words) {
  const std::lock_guard lock(mutex_);
  Side& side = sides_[index];
  side.is_open = false;
  side.trouble = words;
  ++statistics_.lost;
  if (pairing_) pairing_->restart();
}

void CameraDevice::set_controls(std::size_t index, FrameSource& source, std::uint64_t& known) {
  double exposure = 0, gain = 0;
  {
    const std::lock_guard lock(mutex_);
    if (known == controls_) return;
    known = controls_;
    exposure = exposure_;
    gain = gain_;
  }
  std::string refused = exposure >= 0 ? source.set_exposure(exposure) : "";
  const std::string of_gain = gain >= 0 ? source.set_gain(gain) : "";
  if (!of_gain.empty()) refused += (refused.empty() ? "" : ", ") + of_gain;
  if (!refused.empty()) say(true, refused);
  const std::lock_guard lock(mutex_);
  sides_[index].remark = refused;
}

// At the end of a file: all files wait for each other, then begin anew together, or rest.
void CameraDevice::begin_anew_at_end(std::size_t index, FrameSource& source, std::uint64_t& round) {
  std::unique_lock lock(mutex_);
  const auto rewind = [&] {
    round = sides_[index].round;
    const Time start = start_;
    lock.unlock();
    source.rewind(start);
  };
  if (sides_[index].round != round) return rewind();  // begun by another source meanwhile
  const bool is_news = !sides_[index].is_at_end;
  sides_[index].is_at_end = true;
  if (is_news && !options_.loop) {
    lock.unlock();
    say(false, source.name() + " is at its end");
    lock.lock();
  }
  const bool all_ended =
      std::all_of(sides_.begin(), sides_.end(), [](const Side& side) { return side.is_at_end; });
  if (options_.loop && all_ended) {
    start_ = steady_now();
    if (pairing_) pairing_->restart();
    for (Side& side : sides_) {
      side.is_at_end = false;
      ++side.round;
    }
    wake_.notify_all();
  } else {
    wake_.wait_for(lock, std::chrono::milliseconds(200),
                   [&] { return ends_ || sides_[index].round != round; });
  }
  if (sides_[index].round != round) rewind();
}

void CameraDevice::run(std::size_t index) {
  Reopening reopening(
      options_.retry,
      [this, index](bool is_problem, const std::string& words) {
        say(is_problem, words);
        if (!is_problem) return;
        const std::lock_guard lock(mutex_);
        sides_[index].trouble = words;
      },
      options_.grace);
  std::unique_ptr<FrameSource> source;
  std::uint64_t controls = 0, round = 0;
  const auto drop_source = [&](const std::string& words) {
    source.reset();
    lose(index, words);
    reopening.tell(words);
  };
  while (!ends_) {
    if (!source) {
      Time start{};
      {
        const std::lock_guard lock(mutex_);
        start = start_;
        round = sides_[index].round;
      }
      source = reopening.attempt([&] { return open_(index, start); }, kTick);
      if (!source) continue;
      controls = 0;
      const std::lock_guard lock(mutex_);
      Side& side = sides_[index];
      side.trouble.clear();
      side.is_at_end = false;
      side.is_open = true;
      side.rate = source->rate();
      ++statistics_.connections;
      continue;
    }
    try {
      set_controls(index, *source, controls);
      std::optional<Frame> frame = source->next(kTick);
      if (frame) {
        take(index, std::move(*frame));
      } else if (source->is_at_end()) {
        begin_anew_at_end(index, *source, round);
      }
    } catch (const std::exception& error) {  // SourceLost, and what a library may throw
      drop_source(error.what());
    }
  }
}

void CameraDevice::take(std::size_t index, Frame frame) {
  CameraView view;
  {
    const std::lock_guard lock(mutex_);
    ++statistics_.frames[index];
    if (options_.kind == CameraKind::kTwo) {
      if (!pairing_) {
        const double rate = sides_[0].rate > 0 ? sides_[0].rate : sides_[1].rate;
        pairing_.emplace(options_.pair_tolerance > 0
                             ? to_time(options_.pair_tolerance)
                             : FramePairing<Frame>::half_a_frame(rate > 0 ? rate : kAssumedRate));
      }
      const Time stamp = frame.stamp;
      auto pair = pairing_->add(index, stamp, std::move(frame));
      if (!pair) return;
      view.stamp = pair->first.stamp;
      view.is_stamped_by_device = pair->first.item.is_stamped_by_device;
      view.left = std::move(pair->first.item.image);
      view.right = std::move(pair->second.item.image);
    } else if (options_.kind == CameraKind::kSideBySide) {
      view = split_side_by_side(frame);
    } else {
      view = {std::move(frame.image), std::nullopt, frame.stamp, frame.is_stamped_by_device};
    }
    ++statistics_.views;
    last_view_ = steady_now();
  }
  deliver(std::move(view));
}

void CameraDevice::deliver(CameraView view) {
  const std::lock_guard lock(view_mutex_);
  if (delivery_.lets_through(view.stamp)) on_view_(std::move(view));
}

}  // namespace prehend::drivers::camera
