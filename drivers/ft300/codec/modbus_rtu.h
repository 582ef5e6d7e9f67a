#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::ft300 {

// The part of Modbus that the sensor serves: FC03 read holding registers and FC16 write multiple
// registers (MODBUS Application Protocol V1.1b3, sections 6.3 and 6.12; RTU framing: MODBUS over
// Serial Line V1.02, section 2.5.1). Registers are big-endian. The driver speaks through libmodbus;
// the emulator answers with this.

struct ReadRequest {
  std::uint16_t address = 0;
  std::uint16_t count = 0;  // 1..125
  friend bool operator==(const ReadRequest&, const ReadRequest&) = default;
};
struct WriteRequest {
  std::uint16_t address = 0;
  std::vector<std::uint16_t> values;  // 1..123
  friend bool operator==(const WriteRequest&, const WriteRequest&) = default;
};
/// A function that the codec does not know.
struct UnknownRequest {
  std::uint8_t function = 0;
  friend bool operator==(const UnknownRequest&, const UnknownRequest&) = default;
};
using ModbusRequest = std::variant<ReadRequest, WriteRequest, UnknownRequest>;

struct ReadReply {
  std::vector<std::uint16_t> values;
  friend bool operator==(const ReadReply&, const ReadReply&) = default;
};
struct WriteReply {
  std::uint16_t address = 0;
  std::uint16_t count = 0;
  friend bool operator==(const WriteReply&, const WriteReply&) = default;
};
enum class ModbusException : std::uint8_t {
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
};
struct ExceptionReply {
  std::uint8_t function = 0;  // of the request
  ModbusException code = ModbusException::kIllegalAddress;
  friend bool operator==(const ExceptionReply&, const ExceptionReply&) = default;
};
using ModbusReply = std::variant<ReadReply, WriteReply, ExceptionReply>;

/// Function code and data, without address and checksum.
std::vector<std::uint8_t> encode_pdu(const ModbusRequest& request);
std::vector<std::uint8_t> encode_pdu(const ModbusReply& reply);
/// Nothing when it is cut off, too long, or its counts contradict one another.
std::optional<ModbusRequest> decode_request_pdu(Bytes pdu);
std::optional<ModbusReply> decode_reply_pdu(Bytes pdu);

/// RTU: unit | PDU | CRC-16/MODBUS, low byte first.
std::vector<std::uint8_t> encode_rtu(std::uint8_t unit, Bytes pdu);

struct RtuMessage {
  std::uint8_t unit = 0;
  std::vector<std::uint8_t> pdu;
  friend bool operator==(const RtuMessage&, const RtuMessage&) = default;
};
/// One message with nothing around it; nothing when the checksum is wrong or it is shorter than 4.
std::optional<RtuMessage> decode_rtu(Bytes message);

/// Finds requests in a stream of bytes by their lengths and checksums (RTU itself tells messages
/// apart by silences, which a pseudo-terminal does not keep). Functions other than 3 and 16 are
/// recognised when their checksum stands behind 4 bytes of data, as for most.
class RtuRequestDecoder {
 public:
  void add(Bytes bytes);
  std::optional<RtuMessage> next();
  /// Ends a message begun, after a silence.
  void give_up() { buffer_.clear(); }

 private:
  std::vector<std::uint8_t> buffer_;
};

/// Modbus TCP: transaction | 0 | length | unit | PDU, big-endian.
std::vector<std::uint8_t> encode_tcp(std::uint16_t transaction, std::uint8_t unit, Bytes pdu);
struct TcpMessage {
  std::uint16_t transaction = 0;
  std::uint8_t unit = 0;
  std::vector<std::uint8_t> pdu;
};
/// Takes the first whole message off `buffer`. Nothing when more bytes are needed; `broken` is set
/// when the header is none of Modbus, after which the connection has to be closed.
std::optional<TcpMessage> take_tcp(std::vector<std::uint8_t>& buffer, bool& broken);

}  // namespace prehend::drivers::ft300
