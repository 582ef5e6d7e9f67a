#include "drivers/ft300/emulator/sensor.h"

#include <utility>

namespace prehend::drivers::ft300 {
namespace {

constexpr int kStopBytes = 50;
constexpr std::uint16_t kYear = 2018;

}  // namespace

Sensor::Sensor(const SensorOptions& options, Send send)
    : options_(options), send_(std::move(send)) {
  options_.model.resize(3, ' ');
}

std::optional<std::uint16_t> Sensor::register_at(std::uint16_t address) const {
  const MeasurementRegisters values = to_registers(measurement_);
  if (address >= registers::kForce && address < registers::kForce + values.size()) {
    return values[address - registers::kForce];
  }
  const auto letter = [this](std::size_t i) {
    return static_cast<std::uint8_t>(options_.model[i]);
  };
  switch (address) {
    case registers::kAcceleration:
    case registers::kAcceleration + 1:
      return std::uint16_t{0};
    case registers::kAcceleration + 2:
      return std::uint16_t{1000};  // 1 g
    case registers::kFirmware:
      return static_cast<std::uint16_t>(letter(0) << 8 | letter(1));
    case registers::kFirmware + 1:
      return static_cast<std::uint16_t>(letter(2) << 8 | 2);
    case registers::kFirmware + 2:
      return std::uint16_t{0x0001};  // 2.0.1
    case registers::kSerial:
      return std::uint16_t{0x4654};
    case registers::kSerial + 1:
      return std::uint16_t{0x2D00};
    case registers::kSerial + 2:
      return std::uint16_t{1234};
    case registers::kSerial + 3:
      return std::uint16_t{0};
    case registers::kYear:
      return kYear;
    default:
      return std::nullopt;
  }
}

ModbusReply Sensor::reply_to(const ModbusRequest& request) {
  constexpr std::uint8_t kRead = 3, kWrite = 16;
  if (const auto* read = std::get_if<ReadRequest>(&request)) {
    ReadReply reply;
    for (int i = 0; i < read->count; ++i) {
      const auto value = register_at(static_cast<std::uint16_t>(read->address + i));
      if (!value) return ExceptionReply{kRead, ModbusException::kIllegalAddress};
      reply.values.push_back(*value);
    }
    return reply;
  }
  const auto* write = std::get_if<WriteRequest>(&request);
  if (!write) {
    return ExceptionReply{std::get<UnknownRequest>(request).function,
                          ModbusException::kIllegalFunction};
  }
  if (write->address != registers::kOutputSelect || write->values.size() != 1) {
    return ExceptionReply{kWrite, ModbusException::kIllegalAddress};
  }
  if (write->values[0] == registers::kStartStream) {
    if (options_.is_tcp) return ExceptionReply{kWrite, ModbusException::kIllegalValue};
    streams_ = true;
    stop_bytes_ = 0;
  }
  return WriteReply{write->address, 1};
}

void Sensor::receive(Bytes bytes, Time now) {
  last_byte_ = now;
  if (now < boots_until_) return;
  if (streams_) {
    for (const std::uint8_t byte : bytes) {
      stop_bytes_ = byte == 0xFF ? stop_bytes_ + 1 : 0;
      if (stop_bytes_ >= kStopBytes) streams_ = false;
    }
    return;
  }
  if (options_.is_tcp) return serve_tcp(bytes);
  serve_rtu(bytes, now);
}

void Sensor::serve_tcp(Bytes bytes) {
  append_bytes(tcp_, bytes);
  bool broken = false;
  while (const auto message = take_tcp(tcp_, broken)) {
    const auto request = decode_request_pdu(message->pdu);
    if (!request) continue;
    say(encode_tcp(message->transaction, message->unit, encode_pdu(reply_to(*request))));
  }
  if (broken) tcp_.clear();
}

void Sensor::serve_rtu(Bytes bytes, Time now) {
  requests_.add(bytes);
  while (const auto message = requests_.next()) {
    if (message->unit != options_.unit) continue;
    const auto request = decode_request_pdu(message->pdu);
    if (!request) continue;
    say(encode_rtu(message->unit, encode_pdu(reply_to(*request))));
    next_message_ = now + to_time(1 / options_.stream_rate);
  }
}

void Sensor::update(Time now) {
  constexpr auto kGap = std::chrono::milliseconds(30);
  if (now - last_byte_ > kGap) requests_.give_up();
  if (!streams_ || now < next_message_ || now < boots_until_) return;
  next_message_ += to_time(1 / options_.stream_rate);
  if (next_message_ < now) next_message_ = now;
  ++messages_;
  say(encode_stream(measurement_));
}

void Sensor::reboot(Time now) {
  requests_.give_up();
  tcp_.clear();
  stop_bytes_ = 0;
  boots_until_ = now + std::chrono::milliseconds(500);
}

}  // namespace prehend::drivers::ft300
