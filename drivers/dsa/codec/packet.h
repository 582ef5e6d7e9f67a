#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::dsa {

/// Packet ids of the DSACON32-m (SDHLibrary-CPP, sdh/dsa.cpp). A response has its request's id.
enum class PacketId : std::uint8_t {
  kFrame = 0x00,  // pushed, also between a request and its response
  kControllerInfo = 0x01,
  kSensorInfo = 0x02,
  kAcquisition = 0x03,
  kMatrixMask = 0x04,  // layout unknown
  kDescriptor = 0x05,  // layout unknown
  kLoop = 0x06,        // echo
  kControllerState = 0x0A,
  kMatrixInfo = 0x0B,
  kSampleRate = 0x0C,        // layout unknown
  kSetControlVector = 0x0D,  // layout unknown
  kGetControlVector = 0x0E,  // layout unknown
  kSetSensitivity = 0x0F,
  kControllerFeatures = 0x10,  // layout unknown
  kGetSensitivity = 0x12,
  kSetThreshold = 0x13,  // firmware 268 on
  kGetThreshold = 0x14,  // firmware 268 on
  kDynamicMask = 0xAB,   // layout unknown
};

struct Packet {
  std::uint8_t id = 0;  // PacketId
  std::vector<std::uint8_t> payload;
  friend bool operator==(const Packet&, const Packet&) = default;
};

/// Appends AA AA AA | id | size (16 bit, little-endian) | payload | CRC. The CRC (crc16_weiss over
/// id, size and payload) is there only when the payload is not empty.
/// @throws std::length_error for a payload beyond 65535 bytes.
void append_packet(std::vector<std::uint8_t>& bytes, std::uint8_t id, Bytes payload);
std::vector<std::uint8_t> encode_packet(std::uint8_t id, Bytes payload);

/// Finds packets in a stream of bytes that may begin anywhere and hold garbage, such as the ESC [5n
/// that the controller prints at power-up. A preamble that turns out false (size beyond the bound,
/// wrong CRC) costs one byte: the search goes on behind it, so that no whole packet is lost after
/// damage. Memory: what was added and not yet consumed, plus one packet.
class PacketDecoder {
 public:
  /// Larger payloads are taken for garbage. The default fits 32 matrices of 256 texels.
  static constexpr std::size_t kDefaultMostPayload = 16384;
  explicit PacketDecoder(std::size_t most_payload = kDefaultMostPayload)
      : most_payload_(most_payload) {}

  void add(Bytes bytes);
  /// The next whole packet, or nothing until more bytes come. Its payload may be swapped out.
  std::optional<Packet> next();
  std::uint64_t discarded() const { return discarded_; }  // bytes that belonged to no packet
  std::uint64_t bad_checksums() const { return bad_checksums_; }
  bool is_partial() const { return position_ < buffer_.size(); }
  /// After a silence: gives up the packet begun and looks for another behind its first byte.
  void give_up();

 private:
  bool find_preamble();
  void discard(std::size_t count);

  std::size_t most_payload_;
  std::vector<std::uint8_t> buffer_;
  std::size_t position_ = 0;  // of the first byte not yet consumed
  std::uint64_t discarded_ = 0;
  std::uint64_t bad_checksums_ = 0;
};

}  // namespace prehend::drivers::dsa
