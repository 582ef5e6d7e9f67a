#include "drivers/sdh/codec/binary.h"

#include "drivers/wire/encoding/checksum.h"

namespace prehend::drivers::sdh {
namespace {

constexpr std::size_t kChecksum = 2;  // bytes
constexpr std::size_t kHead = 2;      // command and length
constexpr std::size_t kValues = kAxes * sizeof(float);

std::size_t checksum_size(bool has_checksum) { return has_checksum ? kChecksum : 0; }

void append_values(std::vector<std::uint8_t>& bytes, const AxisValues& values) {
  for (const double value : values) append_little(bytes, static_cast<float>(value));
}

void finish(std::vector<std::uint8_t>& bytes, bool has_checksum) {
  bytes[1] = static_cast<std::uint8_t>(bytes.size() - kHead + checksum_size(has_checksum));
  if (has_checksum) append_little(bytes, crc16_weiss(bytes));
}

bool is_whole(Bytes bytes, bool has_checksum) {
  if (!has_checksum) return true;
  const std::size_t content = bytes.size() - kChecksum;
  return load_little<std::uint16_t>(bytes.data() + content) == crc16_weiss(bytes.first(content));
}

AxisValues load_values(const std::uint8_t* bytes) {
  AxisValues values{};
  for (double& value : values) {
    value = static_cast<double>(load_little<float>(bytes));
    bytes += sizeof(float);
  }
  return values;
}

}  // namespace

std::vector<std::uint8_t> encode(const BinaryRequest& request, bool has_checksum) {
  std::vector<std::uint8_t> bytes{request.command, 0,
                                  static_cast<std::uint8_t>(request.values ? kAxes : 0)};
  if (request.values) append_values(bytes, *request.values);
  finish(bytes, has_checksum);
  return bytes;
}

std::vector<std::uint8_t> encode(const BinaryReply& reply, bool has_checksum) {
  std::vector<std::uint8_t> bytes{reply.command, 0, reply.count, reply.status};
  append_values(bytes, reply.values);
  finish(bytes, has_checksum);
  return bytes;
}

std::size_t request_size(std::uint8_t command, std::uint8_t length, bool has_checksum) {
  if (command < kFirstBinary) return 0;
  const std::size_t asks = 1 + checksum_size(has_checksum);
  return length == asks || length == asks + kValues ? kHead + length : 0;
}

std::size_t reply_size(std::uint8_t command, std::uint8_t length, bool has_checksum) {
  if (command < kFirstBinary) return 0;
  return length == 2 + kValues + checksum_size(has_checksum) ? kHead + length : 0;
}

std::optional<BinaryRequest> decode_binary_request(Bytes bytes, bool has_checksum) {
  if (bytes.size() < kHead + 1) return std::nullopt;
  if (request_size(bytes[0], bytes[1], has_checksum) != bytes.size()) return std::nullopt;
  if (!is_whole(bytes, has_checksum)) return std::nullopt;
  BinaryRequest request{bytes[0]};
  const bool has_values = bytes.size() > kHead + 1 + checksum_size(has_checksum);
  if (bytes[2] != (has_values ? kAxes : 0)) return std::nullopt;
  if (has_values) request.values = load_values(bytes.data() + kHead + 1);
  return request;
}

std::optional<BinaryReply> decode_binary_reply(Bytes bytes, bool has_checksum) {
  if (bytes.size() < kHead + 2) return std::nullopt;
  if (reply_size(bytes[0], bytes[1], has_checksum) != bytes.size()) return std::nullopt;
  if (!is_whole(bytes, has_checksum)) return std::nullopt;
  return BinaryReply{bytes[0], bytes[2], bytes[3], load_values(bytes.data() + kHead + 2)};
}

}  // namespace prehend::drivers::sdh
