#include "drivers/dsa/driver/driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace prehend::drivers::dsa {
namespace {

constexpr std::size_t kMostMatrices = 32;
constexpr std::size_t kMostTexels = 8192;
constexpr auto kGap = std::chrono::milliseconds(200);    // of a packet that stalls
constexpr auto kPause = std::chrono::milliseconds(500);  // before it begins anew

std::vector<std::uint8_t> stop_request() {
  // With the run-length bit, as the vendor's library stops.
  return encode(Acquisition{Acquisition::kRunLength, 0});
}

void check_range(bool is_good, const char* words) {
  if (!is_good) throw std::invalid_argument(std::string("DSA: ") + words);
}

}  // namespace

const char* to_string(DriverState state) {
  switch (state) {
    case DriverState::kDisconnected:
      return "disconnected";
    case DriverState::kStopping:
      return "waiting for the controller";
    case DriverState::kAsking:
      return "asking";
    case DriverState::kStreaming:
      return "streaming";
    case DriverState::kStale:
      return "stale";
    case DriverState::kRefused:
      return "refused";
  }
  return "?";
}

Driver::Driver(const DriverOptions& options, Send send, OnFrame on_frame, Note note)
    : options_(options),
      send_(std::move(send)),
      on_frame_(std::move(on_frame)),
      note_(std::move(note)) {
  const auto is_positive = [](double value) { return std::isfinite(value) && value > 0; };
  check_range(options.frame_rate >= 1 && options.frame_rate <= 65535,
              "frame_rate must be from 1 to 65535");
  check_range(!options.sensitivity || (*options.sensitivity >= 0 && *options.sensitivity <= 1),
              "sensitivity must be from 0 to 1");
  check_range(!options.threshold || (*options.threshold >= 0 && *options.threshold <= kFullScale),
              "threshold must be from 0 to 4095");
  check_range(is_positive(options.reply_time) && is_positive(options.stale_time) &&
                  is_positive(options.start_up),
              "times must be positive and finite");
  check_range(options.tries >= 1, "tries must be at least 1");
}

std::size_t Driver::offset(std::size_t matrix) const {
  std::size_t texels = 0;
  for (std::size_t i = 0; i < std::min(matrix, matrices_.size()); ++i) {
    texels += std::size_t{matrices_[i].cells_x} * matrices_[i].cells_y;
  }
  return texels;
}

Statistics Driver::statistics() const {
  Statistics statistics = statistics_;
  statistics.bad_checksums += decoder_.bad_checksums();
  statistics.discarded += decoder_.discarded();
  statistics.lost_frames = lost_frames_.count();
  return statistics;
}

std::uint64_t Driver::damaged() const {
  return statistics_.bad_frames + statistics_.bad_checksums + decoder_.bad_checksums();
}

void Driver::connected(Time now) {
  began_ = now;
  begin(now);
}

void Driver::disconnected(const std::string& why) {
  if (state_ != DriverState::kDisconnected) note_(true, why);
  trouble_ = why;
  state_ = DriverState::kDisconnected;
  question_.reset();
  statistics_.frame_rate = 0;
}

void Driver::begin(Time now) {
  ++statistics_.restarts;
  statistics_.bad_checksums += decoder_.bad_checksums();
  statistics_.discarded += decoder_.discarded();
  decoder_ = PacketDecoder();
  arrivals_.clear();
  lost_frames_.restart();
  statistics_.frame_rate = 0;
  state_ = DriverState::kStopping;
  step_ = 0;
  last_byte_ = now;
  ask(PacketId::kAcquisition, stop_request(), now);
}

void Driver::ask(PacketId id, std::vector<std::uint8_t> payload, Time now) {
  question_ = Question{id, std::move(payload)};
  asked_ = now;
  tries_ = 1;
  send_(encode_packet(static_cast<std::uint8_t>(id), question_->payload));
}

void Driver::give_up(const std::string& words, Time now) {
  if (trouble_ != words) note_(true, words);
  trouble_ = words;
  question_.reset();
  state_ = DriverState::kRefused;
  pause_until_ = now + kPause;
}

void Driver::receive(Bytes bytes, Time now) {
  if (state_ == DriverState::kDisconnected) return;
  last_byte_ = now;
  decoder_.add(bytes);
  while (const auto packet = decoder_.next()) take_packet(*packet, now);
}

void Driver::take_packet(const Packet& packet, Time now) {
  if (packet.id == static_cast<std::uint8_t>(PacketId::kFrame)) return take_frame(packet, now);
  if (question_ && packet.id == static_cast<std::uint8_t>(question_->id)) take_answer(packet, now);
}

void Driver::take_frame(const Packet& packet, Time now) {
  if (state_ != DriverState::kStreaming) return;  // of a stream that is being stopped
  if (!decode_frame(packet.payload, texels_, frame_)) {
    ++statistics_.bad_frames;
    return;
  }
  last_frame_ = now;
  trouble_.clear();
  ++statistics_.frames;
  lost_frames_.take(frame_.timestamp, damaged() - damaged_before_);
  damaged_before_ = damaged();
  arrivals_.push_back(now);
  std::erase_if(arrivals_, [&](Time t) { return now - t > std::chrono::seconds(1); });
  const Time span = now - arrivals_.front();
  statistics_.frame_rate =
      span > Time{} ? static_cast<double>(arrivals_.size() - 1) / to_seconds(span) : 0;
  on_frame_(frame_);
}

// The sequence: stop, controller, sensor, each matrix, sensitivity, threshold, start.
void Driver::take_answer(const Packet& packet, Time now) {
  const auto status = decode_status(packet.payload);
  if (!status) return;  // e.g. an echo
  if (*status != 0) {
    const bool is_option =
        question_->id == PacketId::kSetSensitivity || question_->id == PacketId::kSetThreshold;
    const std::string words = "the controller answers " + describe_status(*status);
    if (!is_option) return give_up(words, now);
    note_(true, words + " to a " +
                    (question_->id == PacketId::kSetThreshold
                         ? "threshold (firmware older than 268 has none)"
                         : "sensitivity") +
                    "; it keeps its own");
  } else if (question_->id == PacketId::kControllerInfo) {
    controller_ = decode_controller_info(packet.payload);
    if (!controller_) return give_up("the controller's information has an unknown layout", now);
  } else if (question_->id == PacketId::kSensorInfo) {
    const auto sensor = decode_sensor_info(packet.payload);
    if (!sensor || sensor->matrices < 1 || sensor->matrices > kMostMatrices) {
      return give_up("the controller has no matrices; are the pads plugged in?", now);
    }
    matrix_count_ = sensor->matrices;
    asked_matrices_.clear();
  } else if (question_->id == PacketId::kMatrixInfo) {
    const auto matrix = decode_matrix_info(packet.payload);
    const std::size_t cells = matrix ? std::size_t{matrix->cells_x} * matrix->cells_y : 0;
    if (cells < 1 || cells > kMostTexels) return give_up("a matrix has an impossible size", now);
    asked_matrices_.push_back(*matrix);
  }
  ++step_;
  next_question(now);
}

void Driver::next_question(Time now) {
  const auto matrix_steps = static_cast<int>(matrix_count_);
  if (step_ == 1) {
    state_ = DriverState::kAsking;
    return ask(PacketId::kControllerInfo, {}, now);
  }
  if (step_ == 2) return ask(PacketId::kSensorInfo, {}, now);
  if (step_ < 3 + matrix_steps) {
    return ask(PacketId::kMatrixInfo, {static_cast<std::uint8_t>(step_ - 3)}, now);
  }
  const int option = step_ - 3 - matrix_steps;
  if (option == 0) {
    if (options_.sensitivity) {
      const auto value = static_cast<float>(*options_.sensitivity);
      return ask(PacketId::kSetSensitivity,
                 encode(SetSensitivity{AdjustFlags::kAllMatrices, 0, value}), now);
    }
    ++step_;
    return next_question(now);
  }
  if (option == 1) {
    if (options_.threshold) {
      const auto value = static_cast<std::uint16_t>(*options_.threshold);
      return ask(PacketId::kSetThreshold, encode(SetThreshold{AdjustFlags::kAllMatrices, 0, value}),
                 now);
    }
    ++step_;
    return next_question(now);
  }
  if (option == 2) {
    matrices_ = asked_matrices_;
    texels_ = offset(matrices_.size());
    const auto flags = static_cast<std::uint8_t>(
        Acquisition::kAcquire | (options_.run_length ? Acquisition::kRunLength : 0));
    return ask(PacketId::kAcquisition,
               encode(Acquisition{flags, static_cast<std::uint16_t>(options_.frame_rate)}), now);
  }
  question_.reset();
  state_ = DriverState::kStreaming;
  last_frame_ = now;
  note_(false, "streaming " + std::to_string(matrices_.size()) + " matrices, " +
                   std::to_string(texels_) + " texels");
}

void Driver::update(Time now) {
  if (state_ == DriverState::kDisconnected) return;
  if (decoder_.is_partial() && now - last_byte_ > kGap) {
    decoder_.give_up();
    while (const auto packet = decoder_.next()) take_packet(*packet, now);
  }
  if (state_ == DriverState::kRefused || state_ == DriverState::kStale) {
    if (now >= pause_until_) begin(now);
    return;
  }
  if (state_ == DriverState::kStreaming) {
    if (now - last_frame_ <= to_time(options_.stale_time)) return;
    char words[64];
    std::snprintf(words, sizeof words, "no tactile frame for %g s", options_.stale_time);
    trouble_ = words;
    note_(true, trouble_);
    state_ = DriverState::kStale;
    statistics_.frame_rate = 0;
    pause_until_ = now;
    return;
  }
  if (question_ && now - asked_ > to_time(options_.reply_time)) {
    asked_ = now;
    ++statistics_.unanswered;
    const bool may_start_up =
        state_ == DriverState::kStopping && now - began_ < to_time(options_.start_up);
    if (tries_++ >= options_.tries && !may_start_up) {
      return give_up("the controller does not answer; is it on, and is this its line?", now);
    }
    send_(encode_packet(static_cast<std::uint8_t>(question_->id), question_->payload));
  }
}

void Driver::stop(Time) {
  if (state_ == DriverState::kDisconnected) return;
  send_(encode_packet(static_cast<std::uint8_t>(PacketId::kAcquisition), stop_request()));
  state_ = DriverState::kDisconnected;
}

}  // namespace prehend::drivers::dsa
