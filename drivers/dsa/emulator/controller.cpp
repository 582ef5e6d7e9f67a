#include "drivers/dsa/emulator/controller.h"

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace prehend::drivers::dsa {
namespace {

constexpr float kFactorySensitivity = 0.5F;
constexpr int kFirstWithThresholds = 268;
constexpr std::uint8_t kGreeting[] = {0x1B, 0x5B, 0x35, 0x6E};  // ESC [5n
constexpr int kGreetings = 3;
constexpr std::size_t kMostPayload = 4096;

bool has_single_frames(int firmware) { return firmware > 288 || firmware == 269; }

std::size_t cells_of(const MatrixShape& shape) {
  return static_cast<std::size_t>(shape.cells_x) * static_cast<std::size_t>(shape.cells_y);
}

}  // namespace

MatrixShape matrix_shape_from(const std::string& text) {
  MatrixShape shape;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  const auto take = [&](auto& number) {
    const auto [after, error] = std::from_chars(at, end, number);
    at = after;
    return error == std::errc{};
  };
  bool is_good = take(shape.cells_x) && at != end && *at++ == 'x' && take(shape.cells_y);
  if (is_good && at != end) is_good = *at++ == '@' && take(shape.texel_pitch) && at == end;
  if (!is_good) {
    throw std::invalid_argument("'" + text +
                                "' is no matrix; write columns x rows as 6x14, or 6x14@3.4 with "
                                "the texel pitch in mm");
  }
  const auto fits = [](int cells) { return cells >= 1 && cells <= 255; };
  if (!fits(shape.cells_x) || !fits(shape.cells_y) || !(shape.texel_pitch > 0)) {
    throw std::invalid_argument("matrix '" + text +
                                "' must have 1 to 255 columns and rows, and a positive pitch");
  }
  return shape;
}

Controller::Controller(const ControllerOptions& options, Send send)
    : options_(options), send_(std::move(send)) {
  std::size_t count = 0;
  for (const MatrixShape& matrix : options.matrices) {
    if (matrix.cells_x < 1 || matrix.cells_x > 255 || matrix.cells_y < 1 || matrix.cells_y > 255) {
      throw std::invalid_argument("a tactile matrix must have 1 to 255 rows and columns");
    }
    count += cells_of(matrix);
  }
  if (count == 0 || !(options.frame_rate > 0)) {
    throw std::invalid_argument("a tactile controller needs matrices and a frame rate");
  }
  texels_.resize(count);
  sensitivities_.resize(options.matrices.size(), kFactorySensitivity);
  thresholds_.resize(options.matrices.size(), 0);
}

void Controller::set_texels(const std::vector<std::uint16_t>& counts) {
  if (counts.size() != texels_.size()) {
    throw std::invalid_argument("expected " + std::to_string(texels_.size()) + " texels, not " +
                                std::to_string(counts.size()));
  }
  std::ranges::transform(counts, texels_.begin(),
                         [](std::uint16_t count) { return std::min(count, kFullScale); });
}

void Controller::reboot(Time now) {
  power_on_ = now;
  is_powered_ = true;
  greetings_ = 0;
  streams_ = false;
  outputs_.clear();
  decoder_ = PacketDecoder(kMostPayload);
  bad_checksums_ = 0;
  line_free_ = now;
}

void Controller::receive(Bytes bytes, Time now) {
  if (!is_powered_) reboot(now);
  if (now - power_on_ < to_time(options_.start_up)) return;
  decoder_.add(bytes);
  while (const auto packet = decoder_.next()) take(*packet, now);
  const auto bad = decoder_.bad_checksums();
  if (std::exchange(bad_checksums_, bad) != bad && options_.answers_errors) {
    answer_status(PacketId::kAcquisition, Status::kChecksumError, now);
  }
}

void Controller::answer(PacketId id, const Payload& payload, Time now) {
  put(encode_packet(static_cast<std::uint8_t>(id), payload), now);
}

void Controller::answer_status(PacketId id, Status status, Time now) {
  answer(id, encode_status(static_cast<std::uint16_t>(status)), now);
}

void Controller::put(std::vector<std::uint8_t> bytes, Time now) {
  const double seconds =
      options_.baud > 0 ? static_cast<double>(bytes.size()) * 10 / options_.baud : 0;
  line_free_ = std::max(line_free_, now) + to_time(seconds);
  outputs_.push_back({line_free_, std::move(bytes)});
}

Payload Controller::matrix_info(std::size_t index) const {
  const MatrixShape& shape = options_.matrices[index];
  MatrixInfo info;
  info.texel_width = info.texel_height = static_cast<float>(shape.texel_pitch);
  info.cells_x = static_cast<std::uint16_t>(shape.cells_x);
  info.cells_y = static_cast<std::uint16_t>(shape.cells_y);
  info.uid[0] = static_cast<std::uint8_t>(index);
  info.full_scale = 250;
  return encode(info);
}

void Controller::take(const Packet& packet, Time now) {
  const auto id = static_cast<PacketId>(packet.id);
  const std::size_t matrix = packet.payload.empty() ? 0 : packet.payload[0];
  const bool has_matrix = packet.payload.size() == 1 && matrix < options_.matrices.size();
  const bool has_thresholds = options_.firmware >= kFirstWithThresholds;
  switch (id) {
    case PacketId::kControllerInfo: {
      ControllerInfo info;
      info.serial = 1234;
      info.hardware = 0x10;
      info.software = static_cast<std::uint16_t>(options_.firmware);
      return answer(id, encode(info), now);
    }
    case PacketId::kSensorInfo: {
      SensorInfo info;
      info.matrices = static_cast<std::uint16_t>(options_.matrices.size());
      return answer(id, encode(info), now);
    }
    case PacketId::kAcquisition:
      return start_or_stop(packet, now);
    case PacketId::kLoop:
      return answer(id, packet.payload, now);
    case PacketId::kMatrixInfo:
      if (!has_matrix) return answer_status(id, Status::kIndexOutOfBounds, now);
      return answer(id, matrix_info(matrix), now);
    case PacketId::kSetSensitivity:
      return adjust(packet, true, now);
    case PacketId::kGetSensitivity: {
      if (!has_matrix) return answer_status(id, Status::kIndexOutOfBounds, now);
      SensitivityInfo info{.adjust_flags = 2, .current = sensitivities_[matrix]};
      info.factory = kFactorySensitivity;
      if (!has_thresholds) info.current = kFactorySensitivity;  // a fault of old firmware
      return answer(id, encode(info), now);
    }
    case PacketId::kSetThreshold:
      if (has_thresholds) return adjust(packet, false, now);
      break;
    case PacketId::kGetThreshold:
      if (!has_thresholds) break;
      if (!has_matrix) return answer_status(id, Status::kIndexOutOfBounds, now);
      return answer(id, encode(ThresholdInfo{0, thresholds_[matrix]}), now);
    default:
      break;
  }
  if (options_.answers_errors) answer_status(id, Status::kUnknownCommand, now);
}

void Controller::start_or_stop(const Packet& packet, Time now) {
  const auto request = decode_acquisition(packet.payload);
  if (!request) return answer_status(PacketId::kAcquisition, Status::kNotEnoughParameters, now);
  answer_status(PacketId::kAcquisition, Status::kSuccess, now);
  streams_ = request->acquires();
  run_length_ = request->run_length();
  next_frame_ = now;
  if (streams_ && request->rate == 0 && has_single_frames(options_.firmware)) {
    put_frame(now);
    streams_ = false;
  }
}

void Controller::adjust(const Packet& packet, bool is_sensitivity, Time now) {
  const auto id = static_cast<PacketId>(packet.id);
  const auto sensitivity = decode_set_sensitivity(packet.payload);
  const auto threshold = decode_set_threshold(packet.payload);
  if (is_sensitivity ? !sensitivity : !threshold) {
    return answer_status(id, Status::kNotEnoughParameters, now);
  }
  const std::uint8_t flags = packet.payload[0];
  const std::size_t matrix = packet.payload[1];
  const bool is_good = is_sensitivity
                           ? sensitivity->sensitivity >= 0 && sensitivity->sensitivity <= 1
                           : threshold->threshold <= kFullScale;
  if (!is_good) return answer_status(id, Status::kRangeError, now);
  const bool is_all = flags & AdjustFlags::kAllMatrices;
  if (!is_all && matrix >= options_.matrices.size()) {
    return answer_status(id, Status::kIndexOutOfBounds, now);
  }
  const bool to_factory = flags & AdjustFlags::kFactory;
  for (std::size_t i = 0; i < options_.matrices.size(); ++i) {
    if (!is_all && i != matrix) continue;
    if (is_sensitivity) {
      sensitivities_[i] = to_factory ? kFactorySensitivity : sensitivity->sensitivity;
    } else {
      thresholds_[i] = to_factory ? std::uint16_t{0} : threshold->threshold;
    }
  }
  if (flags & AdjustFlags::kPersistent) return;  // no answer: a fault of the real firmware
  answer_status(id, Status::kSuccess, now);
}

void Controller::put_frame(Time now) {
  Frame frame{static_cast<std::uint32_t>((now - power_on_) / std::chrono::milliseconds(1)),
              texels_};
  std::size_t texel = 0;
  for (std::size_t m = 0; m < options_.matrices.size(); ++m) {
    for (const std::size_t end = texel + cells_of(options_.matrices[m]); texel < end; ++texel) {
      if (frame.texels[texel] < thresholds_[m] || dead_.contains(texel)) frame.texels[texel] = 0;
    }
  }
  put(encode_packet(static_cast<std::uint8_t>(PacketId::kFrame), encode_frame(frame, run_length_)),
      now);
  ++frames_;
}

void Controller::update(Time now) {
  if (!is_powered_) reboot(now);
  const double age = to_seconds(now - power_on_);
  // Three texts within 0.8 s, from 1 s before it listens on (SDHLibrary).
  while (options_.start_up > 0 && greetings_ < kGreetings &&
         age > options_.start_up - 1 + 0.3 * greetings_) {
    ++greetings_;
    put({std::begin(kGreeting), std::end(kGreeting)}, now);
  }
  if (streams_ && now >= next_frame_ && line_free_ <= now) {
    put_frame(now);
    next_frame_ += to_time(1 / options_.frame_rate);
    if (next_frame_ < now) next_frame_ = now;  // the line is slower than the rate
  }
  while (!outputs_.empty() && outputs_.front().due <= now) {
    if (!silent_) send_(outputs_.front().bytes);
    outputs_.pop_front();
  }
}

}  // namespace prehend::drivers::dsa
