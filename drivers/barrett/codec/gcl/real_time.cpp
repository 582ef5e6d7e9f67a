#include "drivers/barrett/codec/gcl/real_time.h"

#include <algorithm>

#include "drivers/barrett/codec/gcl/line.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr int kMostSpeed = 127;

// Appends, and takes off, bytes in the order of the blocks; numbers of two bytes have their high
// byte first.
class Writer {
 public:
  void byte(int value) { bytes.push_back(static_cast<std::uint8_t>(std::clamp(value, 0, 255))); }
  void signed_byte(int value) {
    bytes.push_back(
        static_cast<std::uint8_t>(static_cast<std::int8_t>(std::clamp(value, -128, 127))));
  }
  void word(int value) { two(std::clamp(value, 0, 65535)); }
  void signed_word(int value) { two(std::clamp(value, -32768, 32767)); }

  std::vector<std::uint8_t> bytes;

 private:
  void two(int value) {
    bytes.push_back(static_cast<std::uint8_t>(value >> 8 & 0xFF));
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  }
};

class Reader {
 public:
  explicit Reader(Bytes bytes) : bytes_(bytes) {}
  int byte() { return bytes_[at_++]; }
  int signed_byte() { return static_cast<std::int8_t>(bytes_[at_++]); }
  int word() {
    const int high = byte();
    return high << 8 | byte();
  }
  int signed_word() { return static_cast<std::int16_t>(word()); }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

std::size_t control_size_of(const MotorLayout& motor) {
  if (!motor.loops) return 0;
  return (motor.velocity ? 1u : 0u) + (motor.gain ? 1u : 0u) + (motor.torque ? 2u : 0u);
}

std::size_t feedback_size_of(const MotorLayout& motor) {
  if (!motor.loops) return 0;
  return (motor.speed ? 1u : 0u) + (motor.strain ? 1u : 0u) + (motor.position ? 2u : 0u) +
         (motor.delta ? 1u : 0u) + (motor.breakaway ? 2u : 0u) + (motor.analog ? 1u : 0u);
}

}  // namespace

std::optional<Firmware> firmware_of(std::string_view version) {
  const std::size_t early = version.find("4.3"), late = version.find("4.4");
  if (early == late) return std::nullopt;  // neither
  return early < late ? Firmware::k4_3 : Firmware::k4_4;
}

std::size_t Layout::control_size() const {
  std::size_t size = 0;
  for (const MotorLayout& motor : motors) size += control_size_of(motor);
  return size;
}

std::size_t Layout::feedback_size() const {
  std::size_t size = 1;
  for (const MotorLayout& motor : motors) size += feedback_size_of(motor);
  return size + (temperature ? (firmware == Firmware::k4_3 ? 2u : 1u) : 0u);
}

std::string Layout::problem() const {
  for (const MotorLayout& motor : motors) {
    if (motor.torque && (motor.velocity || motor.gain)) return "LCT goes with neither LCV nor LCPG";
    const bool is_late = motor.torque || motor.breakaway || motor.analog;
    if (is_late && firmware == Firmware::k4_3) return "firmware 4.3 has no LCT, LFBP and LFAIN";
  }
  return {};
}

std::vector<std::uint8_t> encode_control(Header header, const Controls& controls,
                                         const Layout& layout) {
  Writer writer;
  writer.byte(static_cast<int>(header));
  if (header == Header::kFeedback || header == Header::kAcknowledgement) return writer.bytes;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const MotorLayout& motor = layout.motors[i];
    if (!motor.loops) continue;
    if (motor.velocity) {
      writer.signed_byte(std::clamp(controls[i].velocity, -kMostSpeed, kMostSpeed));
    }
    if (motor.gain) writer.byte(controls[i].gain);
    if (motor.torque) writer.signed_word(controls[i].torque);
  }
  return writer.bytes;
}

std::optional<Controls> decode_control(Bytes data, const Layout& layout) {
  if (data.size() != layout.control_size()) return std::nullopt;
  Reader reader(data);
  Controls controls{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const MotorLayout& motor = layout.motors[i];
    if (!motor.loops) continue;
    if (motor.velocity) controls[i].velocity = reader.signed_byte();
    if (motor.gain) controls[i].gain = reader.byte();
    if (motor.torque) controls[i].torque = reader.signed_word();
  }
  return controls;
}

std::vector<std::uint8_t> encode(const Feedback& feedback, const Layout& layout) {
  Writer writer;
  writer.byte(kLooping);
  for (std::size_t i = 0; i < kAxes; ++i) {
    const MotorLayout& motor = layout.motors[i];
    const MotorFeedback& values = feedback.motors[i];
    if (!motor.loops) continue;
    if (motor.speed) writer.signed_byte(values.speed);
    if (motor.strain) writer.byte(values.strain);
    if (motor.position) writer.signed_word(values.position);
    if (motor.delta) writer.signed_byte(values.delta);
    if (motor.breakaway) writer.word(values.breakaway);
    if (motor.analog) writer.byte(values.analog);
  }
  if (layout.temperature && layout.firmware == Firmware::k4_3) {
    writer.signed_word(feedback.temperature);
  } else if (layout.temperature) {
    writer.signed_byte(feedback.temperature);
  }
  return writer.bytes;
}

std::optional<Feedback> decode_feedback(Bytes block, const Layout& layout) {
  if (block.size() != layout.feedback_size() || block[0] != kLooping) return std::nullopt;
  Reader reader(block.subspan(1));
  Feedback feedback;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const MotorLayout& motor = layout.motors[i];
    MotorFeedback& values = feedback.motors[i];
    if (!motor.loops) continue;
    if (motor.speed) values.speed = reader.signed_byte();
    if (motor.strain) values.strain = reader.byte();
    if (motor.position) values.position = reader.signed_word();
    if (motor.delta) values.delta = reader.signed_byte();
    if (motor.breakaway) values.breakaway = reader.word();
    if (motor.analog) values.analog = reader.byte();
  }
  if (layout.temperature) {
    feedback.temperature =
        layout.firmware == Firmware::k4_3 ? reader.signed_word() : reader.signed_byte();
  }
  return feedback;
}

int delta_of(int way, int coefficient) {
  return std::clamp(way / std::max(1, coefficient), -128, 127);
}

}  // namespace prehend::drivers::barrett::gcl
