#include "drivers/ft300/codec/modbus_rtu.h"

#include "drivers/wire/encoding/checksum.h"

namespace prehend::drivers::ft300 {
namespace {

constexpr std::uint8_t kRead = 0x03, kWrite = 0x10, kExceptionBit = 0x80;
constexpr std::size_t kMostRead = 125, kMostWrite = 123;

void append_big(std::vector<std::uint8_t>& bytes, std::size_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

std::uint16_t load_big(const std::uint8_t* bytes) {
  return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

std::vector<std::uint16_t> load_registers(Bytes bytes) {
  std::vector<std::uint16_t> values;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) values.push_back(load_big(&bytes[i]));
  return values;
}

struct Encoder {
  using Pdu = std::vector<std::uint8_t>;
  Pdu operator()(const ReadRequest& r) const { return pair(kRead, r.address, r.count); }
  Pdu operator()(const WriteRequest& r) const {
    Pdu pdu = pair(kWrite, r.address, r.values.size());
    pdu.push_back(static_cast<std::uint8_t>(2 * r.values.size()));
    for (const std::uint16_t value : r.values) append_big(pdu, value);
    return pdu;
  }
  Pdu operator()(const UnknownRequest& r) const { return {r.function}; }
  Pdu operator()(const ReadReply& r) const {
    Pdu pdu{kRead, static_cast<std::uint8_t>(2 * r.values.size())};
    for (const std::uint16_t value : r.values) append_big(pdu, value);
    return pdu;
  }
  Pdu operator()(const WriteReply& r) const { return pair(kWrite, r.address, r.count); }
  Pdu operator()(const ExceptionReply& r) const {
    return {static_cast<std::uint8_t>(r.function | kExceptionBit),
            static_cast<std::uint8_t>(r.code)};
  }
  static Pdu pair(std::uint8_t function, std::uint16_t address, std::size_t count) {
    Pdu pdu{function};
    append_big(pdu, address);
    append_big(pdu, count);
    return pdu;
  }
};

// Length of the request PDU that begins so, 0: not known yet, as too few bytes are there.
std::size_t request_length(Bytes pdu) {
  if (pdu.empty()) return 0;
  if (pdu[0] != kWrite) return 5;
  return pdu.size() < 6 ? 0 : 6u + pdu[5];
}

}  // namespace

std::vector<std::uint8_t> encode_pdu(const ModbusRequest& r) { return std::visit(Encoder{}, r); }
std::vector<std::uint8_t> encode_pdu(const ModbusReply& r) { return std::visit(Encoder{}, r); }

std::optional<ModbusRequest> decode_request_pdu(Bytes pdu) {
  if (pdu.empty()) return std::nullopt;
  if (pdu[0] != kRead && pdu[0] != kWrite) return UnknownRequest{pdu[0]};
  if (pdu.size() < 5) return std::nullopt;
  const std::uint16_t address = load_big(&pdu[1]);
  const std::size_t count = load_big(&pdu[3]);
  if (pdu[0] == kRead) {
    if (pdu.size() != 5 || count < 1 || count > kMostRead) return std::nullopt;
    return ReadRequest{address, static_cast<std::uint16_t>(count)};
  }
  if (pdu.size() != 6 + 2 * count || count < 1 || count > kMostWrite || pdu[5] != 2 * count) {
    return std::nullopt;
  }
  return WriteRequest{address, load_registers(pdu.subspan(6))};
}

std::optional<ModbusReply> decode_reply_pdu(Bytes pdu) {
  if (pdu.size() < 2) return std::nullopt;
  if (pdu[0] & kExceptionBit) {
    if (pdu.size() != 2) return std::nullopt;
    return ExceptionReply{static_cast<std::uint8_t>(pdu[0] & ~kExceptionBit),
                          static_cast<ModbusException>(pdu[1])};
  }
  if (pdu[0] == kRead && pdu[1] % 2 == 0 && pdu.size() == 2u + pdu[1]) {
    return ReadReply{load_registers(pdu.subspan(2))};
  }
  if (pdu[0] == kWrite && pdu.size() == 5) return WriteReply{load_big(&pdu[1]), load_big(&pdu[3])};
  return std::nullopt;
}

std::vector<std::uint8_t> encode_rtu(std::uint8_t unit, Bytes pdu) {
  std::vector<std::uint8_t> bytes{unit};
  append_bytes(bytes, pdu);
  append_little(bytes, crc16_reflected_8005(bytes, 0xFFFF));
  return bytes;
}

std::optional<RtuMessage> decode_rtu(Bytes message) {
  if (message.size() < 4) return std::nullopt;
  const Bytes checked = message.first(message.size() - 2);
  if (crc16_reflected_8005(checked, 0xFFFF) !=
      load_little<std::uint16_t>(&message[checked.size()])) {
    return std::nullopt;
  }
  return RtuMessage{message[0], {checked.begin() + 1, checked.end()}};
}

void RtuRequestDecoder::add(Bytes bytes) { append_bytes(buffer_, bytes); }

std::optional<RtuMessage> RtuRequestDecoder::next() {
  while (buffer_.size() >= 4) {
    const std::size_t length = request_length(Bytes(buffer_).subspan(1));
    if (length == 0 || buffer_.size() < length + 3) return std::nullopt;
    auto message = decode_rtu(Bytes(buffer_).first(length + 3));
    buffer_.erase(buffer_.begin(),
                  buffer_.begin() + static_cast<std::ptrdiff_t>(message ? length + 3 : 1));
    if (message) return message;
  }
  return std::nullopt;
}

std::vector<std::uint8_t> encode_tcp(std::uint16_t transaction, std::uint8_t unit, Bytes pdu) {
  std::vector<std::uint8_t> bytes;
  append_big(bytes, transaction);
  append_big(bytes, 0);
  append_big(bytes, pdu.size() + 1);
  bytes.push_back(unit);
  append_bytes(bytes, pdu);
  return bytes;
}

std::optional<TcpMessage> take_tcp(std::vector<std::uint8_t>& buffer, bool& broken) {
  constexpr std::size_t kHeader = 6, kMostLength = 254;
  broken = false;
  if (buffer.size() < kHeader) return std::nullopt;
  const std::size_t length = load_big(&buffer[4]);
  broken = load_big(&buffer[2]) != 0 || length < 2 || length > kMostLength;
  if (broken || buffer.size() < kHeader + length) return std::nullopt;
  TcpMessage message{load_big(buffer.data()),
                     buffer[kHeader],
                     {buffer.begin() + kHeader + 1,
                      buffer.begin() + static_cast<std::ptrdiff_t>(kHeader + length)}};
  buffer.erase(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(kHeader + length));
  return message;
}

}  // namespace prehend::drivers::ft300
