#include "prehend/viewing/outbox.h"

#include <algorithm>
#include <utility>

#include "prehend/viewing/protocol.h"

namespace prehend::viewing {

Outbox::Frames::iterator Outbox::erase(Frames::iterator frame) {
  bytes_ -= frame->bytes();
  if (frame->kind == Kind::kStream) --streaming_[frame->subscription];
  return frames_.erase(frame);
}

void Outbox::make_room(const Frame& frame) {
  const auto is_full = [&] { return bytes_ + frame.bytes() > limit_; };
  if (!is_full()) return;
  for (auto old = frames_.begin(); is_full() && old != frames_.end();) {
    if (old->kind != Kind::kStream) {
      ++old;
      continue;
    }
    old = erase(old);
    ++dropped_;
  }
  if (!is_full() || frame.kind != Kind::kLatched) return;
  const auto is_of_it = [&](const Frame& old) {
    return old.kind == Kind::kLatched && old.subscription == frame.subscription &&
           old.sender == frame.sender;
  };
  auto waiting = static_cast<std::size_t>(std::count_if(frames_.begin(), frames_.end(), is_of_it));
  for (auto old = frames_.begin(); is_full() && waiting >= frame.latched && old != frames_.end();) {
    if (is_of_it(*old)) {
      old = erase(old);
      --waiting;
    } else {
      ++old;
    }
  }
}

void Outbox::push(Frame frame) {
  make_room(frame);
  // One message may be larger than all that may wait.
  if (frame.kind == Kind::kStream && bytes_ > 0 && bytes_ + frame.bytes() > limit_) {
    ++dropped_;
    return;
  }
  bytes_ += frame.bytes();
  if (frame.kind == Kind::kStream) ++streaming_[frame.subscription];
  frames_.push_back(std::move(frame));
}

std::optional<Outbox::Frame> Outbox::pop(Time now) {
  if (time_) {
    Frame frame;
    frame.is_text = false;
    frame.payload = std::make_shared<const std::string>(time_frame(*time_));
    time_.reset();
    return frame;
  }
  while (!frames_.empty()) {
    const Frame& first = frames_.front();
    const bool stale = first.kind == Kind::kStream && now - first.since > kStale &&
                       streaming_[first.subscription] > 1;
    if (!stale) break;
    erase(frames_.begin());
    ++dropped_;
  }
  if (frames_.empty()) return std::nullopt;
  Frame frame = frames_.front();
  erase(frames_.begin());
  return frame;
}

void Outbox::forget(std::uint32_t subscription) {
  for (auto frame = frames_.begin(); frame != frames_.end();) {
    const bool is_its = frame->kind != Kind::kWord && frame->subscription == subscription;
    frame = is_its ? erase(frame) : std::next(frame);
  }
  streaming_.erase(subscription);
}

}  // namespace prehend::viewing
